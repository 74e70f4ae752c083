// What `run --quality` sets.
#include "session/quality.h"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "session/settings.h"

namespace pleinair::quality_test {
namespace {

using testing::HasSubstr;

TEST(Quality, EachSettingHasEachQualityAmongItsValues) {
  std::set<std::string> names;
  for (const QualitySetting& setting : QualitySettings()) {
    EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    for (const Quality quality : kAllQualities) {
      EXPECT_EQ(std::count(setting.values.begin(), setting.values.end(), setting.TextAt(quality)),
                1)
          << setting.name << " at " << NameOf(quality);
    }
    EXPECT_LE(setting.IndexAt(Quality::kFast), setting.IndexAt(Quality::kBalanced));
    EXPECT_LE(setting.IndexAt(Quality::kBalanced), setting.IndexAt(Quality::kBest));
    SessionOptions options;
    for (const std::string& value : setting.values) setting.Apply(value, options);
  }
}

// Balanced is what `run` does unasked: where a default changes, the table has to follow.
TEST(Quality, BalancedIsTheDefaults) {
  for (const QualitySetting& setting : QualitySettings()) {
    EXPECT_EQ(setting.balanced, SettingOf(setting.name).standard) << setting.name;
  }
  EXPECT_EQ(QualityInWords(Quality::kBalanced), "");
}

TEST(Quality, FastAndBestDiffer) {
  SessionOptions fast;
  ApplyQuality(Quality::kFast, fast);
  SessionOptions best;
  ApplyQuality(Quality::kBest, best);
  EXPECT_LT(fast.light.samples, SessionOptions{}.light.samples);
  EXPECT_GT(best.light.samples, SessionOptions{}.light.samples);
  EXPECT_LT(fast.compositor.object_samples_per_side, best.compositor.object_samples_per_side);
  EXPECT_THAT(QualityInWords(Quality::kFast), HasSubstr("compositor.object_samples_per_side 2"));
}

}  // namespace
}  // namespace pleinair::quality_test
