// What `run --quality` sets.
#include "apps/quality.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::quality_test {
namespace {

using testing::HasSubstr;

bool NothingGiven(const std::string&) { return false; }

TEST(Quality, EachSettingHasEachQualityAmongItsValues) {
  std::set<std::string> options;
  for (const QualitySetting& setting : QualitySettings()) {
    EXPECT_TRUE(options.insert(setting.option).second) << setting.option;
    for (const Quality quality : kAllQualities) {
      const auto count =
          std::count_if(setting.values.begin(), setting.values.end(), [&](const SweepValue& value) {
            return value.text == setting.TextAt(quality);
          });
      EXPECT_EQ(count, 1) << setting.option << " at " << NameOf(quality);
    }
    EXPECT_LE(setting.IndexAt(Quality::kFast), setting.IndexAt(Quality::kBalanced));
    EXPECT_LE(setting.IndexAt(Quality::kBalanced), setting.IndexAt(Quality::kBest));
  }
}

// Balanced is what `run` does unasked: where a default changes, the table has to follow.
TEST(Quality, BalancedIsTheDefaults) {
  const SessionOptions defaults;
  SessionOptions balanced;
  ApplyQuality(Quality::kBalanced, NothingGiven, balanced);
  EXPECT_EQ(balanced.samples, defaults.samples);
  EXPECT_EQ(balanced.receiver_block_px, defaults.receiver_block_px);
  EXPECT_EQ(balanced.sun_block_px, defaults.sun_block_px);
  EXPECT_EQ(balanced.object_light, defaults.object_light);
  EXPECT_EQ(balanced.object_rays, defaults.object_rays);
  EXPECT_EQ(balanced.penumbra_samples, defaults.penumbra_samples);
  EXPECT_EQ(balanced.object_samples_per_side, defaults.object_samples_per_side);
  EXPECT_EQ(balanced.effects.threshold_code_values, defaults.effects.threshold_code_values);
  EXPECT_EQ(balanced.prepare.rays, GatherOptions{}.rays_per_receiver);
  EXPECT_EQ(QualityInWords(Quality::kBalanced), "");
}

TEST(Quality, AnOptionThatIsGivenWins) {
  SessionOptions options;
  options.samples = 77;
  ApplyQuality(
      Quality::kFast, [](const std::string& name) { return name == "samples"; }, options);
  EXPECT_EQ(options.samples, 77);
  SessionOptions fast;
  ApplyQuality(Quality::kFast, NothingGiven, fast);
  EXPECT_NE(fast.samples, 77);
  EXPECT_EQ(options.object_samples_per_side, fast.object_samples_per_side);
  EXPECT_NE(fast.object_samples_per_side, SessionOptions{}.object_samples_per_side);
  EXPECT_THAT(QualityInWords(Quality::kFast), HasSubstr("object-samples 2"));
}

}  // namespace
}  // namespace pleinair::quality_test
