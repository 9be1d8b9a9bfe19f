// SPDX-License-Identifier: Apache-2.0

// The subcommands of `plumb`, and how they take their options.
#pragma once

#include <CLI/CLI.hpp>

#include <functional>
#include <stdexcept>
#include <string>

namespace plumb::cli {

// Each adds itself to the command line; parsing it does its work and throws what goes wrong. An
// interrupt sets the exit code to 128 + signal.
using AddCommand = void(CLI::App& app, int& exit_code);
AddCommand add_render, add_merge, add_compare, add_converge, add_chart, add_power, add_export,
    add_radiosity, add_reference, add_stress, add_certify, add_diagnose, add_faults, add_manual;

// Adds "--name VALUE" for what CLI11 can read itself: texts, and lists of them.
template <typename Target>
CLI::Option* add_option(CLI::App& command, const std::string& name, const std::string& value,
                        Target& target, const std::string& help) {
  return command.add_option(name, target, help)->type_name(value);
}

// Adds "--name VALUE"; `parse` turns the text into a value or throws std::invalid_argument.
template <typename Target, typename Parse>
CLI::Option* add_option(CLI::App& command, const std::string& name, const std::string& value,
                        Target& target, Parse parse, const std::string& help) {
  const auto store = [name, parse, &target](const std::string& text) {
    try {
      target = parse(text);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(name, error.what());
    }
  };
  return command.add_option_function<std::string>(name, store, help)->type_name(value);
}

// For each text of a list, what `parse` refuses it with, else nothing.
template <typename Parse>
std::function<std::string(const std::string&)> refused_by(Parse parse) {
  return [parse](const std::string& text) -> std::string {
    try {
      parse(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
}

}  // namespace plumb::cli
