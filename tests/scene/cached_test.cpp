#include "scene/cached.h"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace pleinair::cached_test {
namespace {

TEST(Cached, MakesAValueOnceForAKey) {
  Cached<std::string, int> cached;
  int made = 0;
  const auto get = [&](int key) {
    return cached.Get(key, [&] { return std::to_string(key) + (++made > 0 ? "!" : ""); });
  };
  EXPECT_FALSE(cached.IsOf(0)) << "a key that equals the key type's own start is none yet";
  EXPECT_EQ(get(0), "0!");
  EXPECT_EQ(get(0), "0!");
  EXPECT_EQ(made, 1);
  EXPECT_EQ(get(7), "7!");
  EXPECT_TRUE(cached.IsOf(7));
  EXPECT_FALSE(cached.IsOf(0));
  EXPECT_EQ(get(0), "0!");
  EXPECT_EQ(made, 3);
}

TEST(Cached, KeepsNothingWhereMakingFails) {
  Cached<int, int> cached;
  cached.Get(1, [] { return 10; });
  EXPECT_THROW(cached.Get(2, []() -> int { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_FALSE(cached.IsOf(2));
  EXPECT_FALSE(cached.IsOf(1));
  EXPECT_EQ(cached.Get(1, [] { return 11; }), 11);
}

}  // namespace
}  // namespace pleinair::cached_test
