// What tests of commands share: a folder of their own, and what a command says in refusing.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair {

// A fixture whose folder_ is empty at first, and gone after the test.
class CommandFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("pleinair_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  // One line, or "accepted".
  template <typename Options>
  static std::string Refusal(std::string (*run)(const Options&), const Options& options) {
    try {
      run(options);
    } catch (const std::exception& error) {
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
      return error.what();
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

}  // namespace pleinair
