// The subcommands of `plumb`, and how they take their options.
#pragma once

#include <CLI/CLI.hpp>

#include <stdexcept>
#include <string>

namespace plumb::cli {

// Each adds itself to the command line; parsing it does its work and throws what goes wrong. An
// interrupt sets the exit code to 128 + signal.
void add_render(CLI::App& app, int& exit_code);
void add_merge(CLI::App& app);
void add_compare(CLI::App& app, int& exit_code);
void add_converge(CLI::App& app, int& exit_code);
void add_chart(CLI::App& app, int& exit_code);
void add_power(CLI::App& app, int& exit_code);
void add_export(CLI::App& app);
void add_reference(CLI::App& app, int& exit_code);
void add_stress(CLI::App& app, int& exit_code);

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

}  // namespace plumb::cli
