#include "session/available_memory.h"

#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::available_memory_test {
namespace {

TEST(AvailableMemory, SaysWhatIsMissingAndWhatToDo) {
  ASSERT_GT(AvailableMemoryBytes(), std::size_t{1} << 20);  // This test runs in some.
  EXPECT_NO_THROW(RequireMemory(1, "the work", "do less"));
  try {
    RequireMemory(std::numeric_limits<std::size_t>::max(), "the work", "do less");
    FAIL() << "2^64 bytes were there";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the work may take"));
    EXPECT_THAT(error.what(), testing::EndsWith("do less"));
  }
}

}  // namespace
}  // namespace pleinair::available_memory_test
