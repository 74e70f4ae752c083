#include "session/settings.h"

#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/session/command_folder.h"

namespace pleinair::settings_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::string RefusalOf(const std::string& assignment) {
  SessionOptions options;
  try {
    ApplySetting(assignment, options);
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  return "accepted";
}

TEST(Settings, AreListedOnceAndInFull) {
  std::set<std::string> names;
  for (const Setting& setting : Settings()) {
    EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    EXPECT_THAT(setting.meaning, Not(IsEmpty())) << setting.name;
    EXPECT_THAT(setting.values, Not(IsEmpty())) << setting.name;
    EXPECT_THAT(setting.standard, Not(IsEmpty())) << setting.name;
  }
  EXPECT_GT(names.size(), 40u);
}

TEST(Settings, RefuseWhatIsNotAmongTheirValues) {
  for (const Setting& setting : Settings()) {
    for (const char* text : {"", " ", "nonsense", "-1", "nan", "1e400"}) {
      EXPECT_THAT(RefusalOf(setting.name + "=" + text),
                  AllOf(HasSubstr(setting.name + ": expected "), HasSubstr("found '")))
          << text;
    }
  }
}

TEST(Settings, RefuseWholeNumbersThatNoNumberHolds) {
  for (const char* name : {"light.samples", "light.seed", "prepare.rays", "prepare.bounces"}) {
    EXPECT_THAT(RefusalOf(std::string(name) + "=99999999999999999999"), HasSubstr("expected "))
        << name;
  }
}

TEST(Settings, ReachTheFieldsThatTheyAreNamedAfter) {
  SessionOptions options;
  ApplySetting("light.samples = 77", options);
  ApplySetting("light.fit.loss=huber", options);
  ApplySetting("light.sky_shapes=overcast,uniform", options);
  ApplySetting("haze=0.2", options);
  ApplySetting("prepare.bounces=all", options);
  ApplySetting("prepare.patch_size_m=0.75", options);
  ApplySetting("prepare.probe_counts=2x3x4", options);
  ApplySetting("sky_regions=4x16", options);
  ApplySetting("pipeline.effects.threshold_code_values=0", options);
  ApplySetting("pipeline.filter=off", options);
  ApplySetting("camera_noise.read_noise_electrons=3", options);
  ApplySetting("compositor.object_samples_per_side=8", options);
  EXPECT_EQ(options.light.samples, 77);
  EXPECT_EQ(options.light.fit.loss, LightingFitOptions::Loss::kHuber);
  EXPECT_THAT(options.light.sky_shapes,
              testing::ElementsAre(SkyShapeKind::kOvercast, SkyShapeKind::kUniform));
  EXPECT_EQ(options.haze, 0.2);
  EXPECT_EQ(options.prepare.bounces, kAllBounces);
  EXPECT_EQ(options.prepare.patch_size_m, 0.75);
  EXPECT_EQ(options.prepare.probe_counts, glm::ivec3(2, 3, 4));
  EXPECT_TRUE(options.sky_regions.has_value());
  EXPECT_EQ(options.pipeline.effects.threshold_code_values, 0.0);
  EXPECT_FALSE(options.pipeline.filter.has_value());
  EXPECT_TRUE(options.camera_noise_is_known);
  EXPECT_EQ(options.compositor.object_samples_per_side, 8);
}

TEST(Settings, AnUnknownNameIsAnsweredByTheNearest) {
  EXPECT_THAT(RefusalOf("light.sample=100"),
              AllOf(HasSubstr("'light.sample' is no setting"), HasSubstr("such as light.samples")));
  EXPECT_THAT(RefusalOf("light.samples"), HasSubstr("expected name=value"));
  EXPECT_THAT(RefusalOf("light.sky_shapes=clear,clear"), HasSubstr("expected some of uniform"));
  EXPECT_THAT(RefusalOf("sky_regions=4x"), HasSubstr("expected BANDSxSECTORS"));
  EXPECT_THAT(RefusalOf("prepare.probe_counts=4x4x65"), HasSubstr("up to 64 each"));
}

class SettingsFile : public CommandFolder {};

TEST_F(SettingsFile, IsAppliedCompletelyOrNotAtAll) {
  SessionOptions options;
  EXPECT_THAT(
      ApplySettings(Write("good", "# for a slow machine\n\nlight.samples=100\r\n light.seed = 9"),
                    options),
      testing::ElementsAre("light.samples=100", "light.seed = 9"));
  EXPECT_EQ(options.light.samples, 100);
  EXPECT_EQ(options.light.seed, 9u);
  const auto refusal = [&](const std::filesystem::path& file) -> std::string {
    try {
      ApplySettings(file, options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal(Write("bad", "light.samples=200\nlight.samples=0\n")),
              AllOf(HasSubstr("bad:2: light.samples: expected 1 to 100000"), HasSubstr("'0'")));
  EXPECT_EQ(options.light.samples, 100);
  EXPECT_THAT(refusal(folder_ / "absent"), HasSubstr("expected a file of settings"));
  EXPECT_THAT(refusal(folder_), HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace pleinair::settings_test
