#include "apps/set_aside.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(SetAside, NamesAFolderThatIsNotThere) {
  const TemporaryFolder folder;
  EXPECT_THAT(MessageOf([&] { SetAside(folder / "none"); }), testing::HasSubstr("/none: "));
}

}  // namespace
}  // namespace pleinair::set_aside_test
