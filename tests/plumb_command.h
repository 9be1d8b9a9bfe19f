// SPDX-License-Identifier: Apache-2.0

// Runs `plumb` as a user would run it, each test in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace plumb {

struct Result {
  int exit_code;
  std::string output;  // on stderr, too
};

class PlumbCommand : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder = std::filesystem::path(testing::TempDir()) /
             (std::string("plumb-") + test->test_suite_name() + "-" + std::to_string(getpid()) +
              "-" + test->name());
    std::filesystem::create_directories(folder);
  }

  void TearDown() override { std::filesystem::remove_all(folder); }

  Result plumb(const std::string& arguments) const {
    const std::string command =
        "cd '" + folder.string() + "' && '" PLUMB_EXECUTABLE "' " + arguments + " 2>&1";
    std::FILE* pipe = popen(command.c_str(), "r");
    Result result;
    char buffer[4096];
    while (const size_t n = std::fread(buffer, 1, sizeof(buffer), pipe)) {
      result.output.append(buffer, n);
    }
    result.exit_code = WEXITSTATUS(pclose(pipe));
    return result;
  }

  std::filesystem::path folder;
};

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace plumb
