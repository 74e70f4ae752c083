#include "scene/state_id.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

namespace pleinair::state_id_test {
namespace {

TEST(StateId, EqualsItsCopiesAlone) {
  const StateId first = StateId::Next();
  const StateId copy = first;
  EXPECT_EQ(copy, first);
  EXPECT_NE(StateId::Next(), first);
  EXPECT_TRUE(first.IsSet());
  EXPECT_FALSE(StateId().IsSet());
  EXPECT_EQ(StateId(), StateId());
}

TEST(StateId, IsUniqueOverThreads) {
  std::vector<StateId> ids(1000);
  tbb::parallel_for(std::size_t{0}, ids.size(), [&](std::size_t i) { ids[i] = StateId::Next(); });
  for (const StateId& id : ids) EXPECT_EQ(std::count(ids.begin(), ids.end(), id), 1);
}

}  // namespace
}  // namespace pleinair::state_id_test
