#include "scene/internal/isolated_work.h"

#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::isolated_work_test {
namespace {

constexpr IsolationLimits kLimits{std::uint64_t{256} << 20U, std::chrono::seconds(1)};
constexpr const char* kTooMuch = "its reader needs more than 256 MiB or 1 s";

std::string Message(const std::function<std::string()>& work) {
  return MessageOf([&] { RunIsolated(work, kLimits); });
}

TEST(IsolatedWork, ReturnsWhatTheWorkReturns) {
  EXPECT_EQ(RunIsolated([] { return std::string("a\0b", 3); }, kLimits), std::string("a\0b", 3));
  EXPECT_EQ(RunIsolated([] { return std::string(); }, kLimits), "");
  // More than a pipe holds.
  std::string much(std::size_t{10} << 20U, 'x');
  EXPECT_EQ(RunIsolated([&] { return much; }, kLimits), much);
}

TEST(IsolatedWork, KeepsTheWorksChangesAway) {
  int value = 1;
  RunIsolated(
      [&] {
        value = 2;
        return std::string();
      },
      kLimits);
  EXPECT_EQ(value, 1);
}

TEST(IsolatedWork, ThrowsTheWorksMessage) {
  EXPECT_EQ(Message([]() -> std::string { throw std::runtime_error("wrong"); }), "wrong");
}

TEST(IsolatedWork, OutlivesACrash) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGKILL}) {
    EXPECT_EQ(Message([signal] {
                std::raise(signal);
                return std::string();
              }),
              "its reader crashed");
  }
  // An end that is not by a signal is no result either.
  EXPECT_EQ(Message([]() -> std::string { std::_Exit(0); }), "its reader crashed");
}

TEST(IsolatedWork, StopsWorkWithoutEnd) {
  volatile int turns = 0;
  EXPECT_EQ(Message([&] {
              while (true) turns = turns + 1;
              return std::string();
            }),
            kTooMuch);
}

// By mmap, as allocators of sanitizers end the process where there is no more.
TEST(IsolatedWork, BoundsMemory) {
  EXPECT_EQ(
      Message([]() -> std::string {
        constexpr std::size_t kBlock = std::size_t{1} << 20U;
        while (mmap(nullptr, kBlock, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED) {
        }
        throw std::bad_alloc();
      }),
      kTooMuch);
}

}  // namespace
}  // namespace pleinair::isolated_work_test
