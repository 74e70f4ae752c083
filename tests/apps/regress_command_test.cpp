// `pleinair regress`, and the check of the recordings against what they once reached.
#include "apps/regress_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/regression_baseline.h"
#include "tests/session/command_folder.h"

namespace pleinair::regress_command_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const fs::path kSamples = PLEINAIR_SOURCE_DIR "/datasets/samples";
const fs::path kRecordings = PLEINAIR_SHARED_DIR "/sequences";

class RegressCommand : public CommandFolder {
 protected:
  // Coarse, one frame, light alone: some tenths of a second.
  RegressCommandOptions Quick() const {
    RegressCommandOptions options;
    options.folder = kSamples;
    options.cache = folder_ / "cache";
    options.baseline = folder_ / "baseline.json";
    return options;
  }
  static std::string RefusalOf(const RegressCommandOptions& options) {
    return Refusal(
        +[](const RegressCommandOptions& asked) { return RunRegressCommand(asked).table; },
        options);
  }
};

TEST_F(RegressCommand, TheBundledSequenceIsAsGoodAsItsBaseline) {
  RegressCommandOptions options;
  options.folder = kSamples;
  options.cache = folder_ / "cache";
  const RegressResult result = RunRegressCommand(options);
  EXPECT_THAT(result.reasons, IsEmpty()) << result.table;
  EXPECT_THAT(result.table, HasSubstr("PSNR on the object"));
}

// One test each, so that they can be run side by side.
class RecordingRegression : public RegressCommand,
                            public testing::WithParamInterface<const char*> {};

TEST_P(RecordingRegression, IsAsGoodAsItsBaseline) {
  RegressCommandOptions options;
  options.folder = kRecordings / GetParam();
  if (!fs::exists(options.folder)) GTEST_SKIP() << options.folder << " is not there";
  options.baseline = PLEINAIR_SOURCE_DIR "/datasets/baselines/recordings-quick.json";
  options.cache = folder_ / "cache";
  const RegressResult result = RunRegressCommand(options);
  EXPECT_THAT(result.reasons, IsEmpty()) << result.table;
  EXPECT_THAT(result.table, HasSubstr("frames done"));
}

INSTANTIATE_TEST_SUITE_P(
    Recordings,
    RecordingRegression,
    testing::Values("courtyard-clouds", "parking-shadow", "room-window", "berlin-photos"),
    [](const auto& name) {
      std::string word = name.param;
      std::replace(word.begin(), word.end(), '-', '_');
      return word;
    });

// The other figures are those of a moment ago.
TEST_F(RegressCommand, ReportsAFigureThatGotWorseByMoreThanItsNoise) {
  RegressCommandOptions options = Quick();
  const FigureSettings elsewhere{3, false, {"prepare.patch_size_m=0.5", "prepare.rays=32"}};
  WriteRegressionBaseline({{"elsewhere", {elsewhere, {{"frames_done", {3.0}}}}}}, options.baseline);
  options.write_baseline = true;
  options.seeds = 2;
  options.settings = {1, false, {"prepare.patch_size_m=4", "prepare.rays=16"}};
  RunRegressCommand(options);

  RegressionBaseline baseline = ReadRegressionBaseline(options.baseline);
  EXPECT_EQ(baseline.at("elsewhere").settings, elsewhere) << "stays";
  EXPECT_THAT(baseline.at("elsewhere").figures.at("frames_done"), ElementsAre(3.0));
  SequenceBaseline& courtyard = baseline.at("courtyard");
  EXPECT_THAT(courtyard.figures.at("sun_error_median"), SizeIs(2)) << "one for each seed";
  courtyard.figures.at("inlier_share_median") = {1.5, 1.5};
  courtyard.figures["sky_error_95th"] = {1e-6, 2e-6};
  WriteRegressionBaseline(baseline, options.baseline);
  options = Quick();
  options.out = folder_ / "regress.json";
  const RegressResult result = RunRegressCommand(options);
  EXPECT_THAT(result.reasons,
              ElementsAre(HasSubstr("courtyard: inliers"), HasSubstr("courtyard: sky error")));
  EXPECT_THAT(result.table, HasSubstr("WORSE"));
  std::ifstream stream(options.out);
  const nlohmann::json json = nlohmann::json::parse(stream);
  EXPECT_TRUE(json.at("got_worse").get<bool>());
  EXPECT_TRUE(
      json.at("sequences").at("courtyard").at("figures").at("sky_error_95th").at("got_worse"));
}

TEST_F(RegressCommand, WritesABaselineOnlyWhenAskedTo) {
  EXPECT_THAT(RefusalOf(Quick()), HasSubstr("baseline.json: expected a baseline there"));
  EXPECT_FALSE(fs::exists(folder_ / "baseline.json"));
}

// One of two sequences is broken: the other is still checked.
TEST_F(RegressCommand, ASequenceThatCannotBeRunIsAReasonOfItsOwn) {
  Write("baseline.json",
        R"({"format": "pleinair-baseline-2", "sequences": {"courtyard": {"settings":
            {"frames_limit": 1, "pictures": false,
             "set": ["prepare.patch_size_m=4", "prepare.rays=16"]},
            "figures": {"frames_done": [1]}}}})");
  fs::create_directories(folder_ / "many" / "broken");
  Write("many/broken/sequence.json", "{}");
  fs::create_directory_symlink(kSamples / "courtyard", folder_ / "many" / "courtyard");
  RegressCommandOptions options = Quick();
  options.folder = folder_ / "many";
  const RegressResult result = RunRegressCommand(options);
  EXPECT_THAT(result.reasons, ElementsAre(HasSubstr("broken: cannot be run: ")));
  EXPECT_THAT(result.table, HasSubstr("frames done"));
}

TEST_F(RegressCommand, RefusesWhatIsNoSequenceAndNoBaseline) {
  RegressCommandOptions options = Quick();
  options.folder = folder_ / "nowhere";
  EXPECT_THAT(RefusalOf(options), HasSubstr("nowhere: expected a sequence"));
  options.folder = folder_;
  EXPECT_THAT(RefusalOf(options), HasSubstr("expected folders with a sequence.json"));
  options = Quick();
  options.settings.pictures = false;
  EXPECT_THAT(RefusalOf(options), HasSubstr("--write-baseline"));
  options = Quick();
  Write("baseline.json", "[]");
  EXPECT_THAT(RefusalOf(options), HasSubstr("expected an object"));
  Write("baseline.json", R"({"format": "pleinair-sequence"})");
  EXPECT_THAT(RefusalOf(options), HasSubstr("format: expected \"pleinair-baseline-2\""));
  Write("baseline.json", "{");
  EXPECT_THAT(RefusalOf(options), HasSubstr("expected valid JSON"));
  const std::string head = R"({"format": "pleinair-baseline-2", "sequences": {"a": )";
  Write("baseline.json", head + "3}}");
  EXPECT_THAT(RefusalOf(options), HasSubstr("sequences.a: expected an object"));
  Write("baseline.json", head + R"({"settings": {"colour": 1}, "figures": {}}}})");
  EXPECT_THAT(RefusalOf(options),
              testing::AllOf(HasSubstr("sequences.a.settings: expected only known keys"),
                             HasSubstr("found \"colour\"")));
  // A text of it, for the message, would overflow the stack.
  Write("baseline.json",
        head + R"({"settings": {"set": )" + std::string(1'000'000, '[') +
            std::string(1'000'000, ']') + R"(}, "figures": {}}}})");
  EXPECT_THAT(RefusalOf(options), HasSubstr("64 levels of nesting"));
  for (const char* assignment : {"light.colour=3", "prepare.rays=1", "prepare.rays"}) {
    Write("baseline.json",
          head + R"({"settings": {"set": [")" + assignment + R"("]}, "figures": {}}}})");
    EXPECT_THAT(RefusalOf(options),
                testing::AllOf(HasSubstr("sequences.a.settings.set[0]: expected a setting"),
                               HasSubstr(assignment)));
  }
  for (const char* number : {"4294967297", "1000000000000", "-1", "1.5"}) {
    Write("baseline.json",
          head + R"({"settings": {"frames_limit": )" + number + R"(}, "figures": {}}}})");
    EXPECT_THAT(RefusalOf(options), HasSubstr("sequences.a.settings.frames_limit: expected"))
        << number;
  }
  Write("baseline.json", head + R"({"settings": {}, "figures": {"frames_done": ["three"]}}}})");
  EXPECT_THAT(RefusalOf(options), HasSubstr("sequences.a.figures.frames_done"));
}

TEST(SpreadOver, TakesFirstAndLastAndWhatIsEvenlyBetween) {
  EXPECT_THAT(SpreadOver(5, 3), ElementsAre(true, false, true, false, true));
  EXPECT_THAT(SpreadOver(3, 0), ElementsAre(true, true, true));
  EXPECT_THAT(SpreadOver(3, 9), ElementsAre(true, true, true));
  EXPECT_THAT(SpreadOver(3, 1), ElementsAre(true, false, false));
  EXPECT_THAT(SpreadOver(0, 2), IsEmpty());
}

}  // namespace
}  // namespace pleinair::regress_command_test
