#include "apps/set_aside.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/file_size_limit.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::set_aside_test {
namespace {

std::string BytesOf(int i) {
  return std::string(static_cast<std::size_t>(1000 + i % 7), static_cast<char>('a' + i % 26));
}

TEST(SetAside, LeavesNothingInItsFolder) {
  const TemporaryFolder folder;
  SetAside aside(folder.Path());
  const SetAside::Place place = aside.Add(std::string("a\0b", 3));
  EXPECT_EQ(aside.Read(place), std::string("a\0b", 3));
  EXPECT_EQ(folder.FileCount(), 0u);
}

// As a report that halves its pictures again and again.
TEST(SetAside, ReusesTheSpaceOfWhatIsForgotten) {
  const TemporaryFolder folder;
  SetAside aside(folder.Path());
  std::vector<std::pair<int, SetAside::Place>> kept;
  for (int i = 0; i < 10'000; ++i) {
    kept.emplace_back(i, aside.Add(BytesOf(i)));
    if (kept.size() < 100) continue;
    std::erase_if(kept, [n = 0](const auto&) mutable { return n++ % 2 == 1; });
    std::vector<SetAside::Place*> places;
    places.reserve(kept.size());
    for (auto& [number, place] : kept) places.push_back(&place);
    aside.KeepOnly(places);
  }
  EXPECT_LE(aside.Bytes(), 100 * 1006);
  for (const auto& [number, place] : kept) EXPECT_EQ(aside.Read(place), BytesOf(number));
}

// Pictures of a report that is thinned out, before and after the disk is full.
TEST(SetAside, GoesOnInMemoryWhereTheDiskIsFull) {
  const TemporaryFolder folder;
  SetAside aside(folder.Path(), 0);
  std::vector<SetAside::Place> places;
  places.reserve(3000);
  for (int i = 0; i < 100; ++i) places.push_back(aside.Add(BytesOf(i)));
  EXPECT_FALSE(aside.IsInMemory());
  {
    // In the middle of the first one that is beyond what was held.
    const FileSizeLimit limit(2'000'000 + 500);
    for (int i = 100; i < 3000; ++i) places.push_back(aside.Add(BytesOf(i)));
  }
  EXPECT_TRUE(aside.IsInMemory());
  for (int i = 0; i < 3000; ++i) {
    ASSERT_EQ(aside.Read(places[static_cast<std::size_t>(i)]), BytesOf(i)) << i;
  }
  std::vector<SetAside::Place*> kept;
  kept.reserve(places.size() / 2);
  for (std::size_t i = 0; i < places.size(); i += 2) kept.push_back(&places[i]);
  aside.KeepOnly(kept);
  const SetAside::Place last = aside.Add("last");
  aside.LeaveRoom();
  for (int i = 0; i < 3000; i += 2) {
    ASSERT_EQ(aside.Read(places[static_cast<std::size_t>(i)]), BytesOf(i)) << i;
  }
  EXPECT_EQ(aside.Read(last), "last");
}

TEST(SetAside, TakesNoRoomOfADiskThatIsNearlyFull) {
  const TemporaryFolder folder;
  SetAside aside(folder.Path(), std::numeric_limits<std::int64_t>::max());
  EXPECT_FALSE(aside.IsInMemory());
  const SetAside::Place place = aside.Add(BytesOf(0));
  EXPECT_TRUE(aside.IsInMemory());
  EXPECT_EQ(aside.Read(place), BytesOf(0));
}

TEST(SetAside, NamesAFolderThatIsNotThere) {
  const TemporaryFolder folder;
  EXPECT_THAT(MessageOf([&] { SetAside(folder / "none"); }), testing::HasSubstr("/none: "));
}

}  // namespace
}  // namespace pleinair::set_aside_test
