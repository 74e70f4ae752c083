// `pleinair run`: what it leaves in its folder, and what another run makes of that.
#include "apps/run_command.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/lighting_record.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "tests/scene/file_size_limit.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/command_folder.h"

namespace pleinair::run_command_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RunCommand : public CommandFolder {
 protected:
  // The first frames of the bundled sequence, coarsely prepared, under a sky that no shape's name
  // describes: bright in the east.
  void SetUp() override {
    CommandFolder::SetUp();
    RgbImage sky(64, 32);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double east = std::max(DirectionFromLatLong({x + 0.5, y + 0.5}, {64, 32}).x, 0.0);
        sky.At(x, y) = glm::vec3(static_cast<float>(10.0 + 200.0 * east * east));
      }
    }
    WriteExr(folder_ / "east.exr", sky, ExrPrecision::kHalf);
    std::string lines;
    for (int frame = 0; frame < 2; ++frame) {
      lines +=
          fmt::format(R"({{"frame": {}, "sun_irradiance_rgb": [0, 0, 0], "sky_image": "east.exr", )"
                      R"("sky_irradiance_rgb": [60, 90, {}]}})"
                      "\n",
                      frame,
                      frame == 0 ? "120" : "4e6");  // The second sky is beyond half floats.
    }
    options_.sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
    options_.cache = folder_ / "cache";
    options_.out = folder_ / "out";
    options_.lighting = Write("given.jsonl", lines);
    options_.prepare.patch_size_m = 4.0;
    options_.prepare.rays = 16;
  }

  RunCommandOptions options_;
};

TEST_F(RunCommand, CanBeRunAgainByTheLightThatItWrote) {
  RunRunCommand(options_);
  RunCommandOptions again = options_;
  again.lighting = options_.out / "lighting.jsonl";
  again.out = folder_ / "again";
  RunRunCommand(again);
  const auto given = ReadLightingRecords(again.lighting);
  const auto replayed = ReadLightingRecords(again.out / "lighting.jsonl");
  for (std::size_t frame = 0; frame < 2; ++frame) {
    ASSERT_FALSE(replayed.at(frame).error) << *replayed.at(frame).error;
    EXPECT_EQ(replayed[frame].light.sky_irradiance_rgb, given.at(frame).light.sky_irradiance_rgb);
    const std::string name = fmt::format("composite/{:06}.exr", frame);
    const RgbImage first = ReadRadianceImage(options_.out / name);
    const RgbImage second = ReadRadianceImage(again.out / name);
    const RgbImage bare =
        ReadRadianceImage(fmt::format("{}/frames/{:06}.exr", options_.sequence.string(), frame));
    double difference = 0.0;
    double change = 0.0;
    for (std::size_t i = 0; i < first.pixels.size(); ++i) {
      difference += std::abs(double{first.pixels[i].g} - double{second.pixels[i].g});
      change += std::abs(double{first.pixels[i].g} - double{bare.pixels[i].g});
    }
    EXPECT_GT(change, 0.0);
    // A sky of 5.6 deg a pixel, which the run's own picture of it interpolates.
    EXPECT_LT(difference, 0.01 * change) << "frame " << frame;
  }
}

// Other shapes than the frame before, and fewer: nothing of the earlier light can stand in.
TEST_F(RunCommand, TakesSkiesOfOtherShapesFromFrameToFrame) {
  options_.lighting = Write(
      "shapes.jsonl",
      R"({"frame": 0, "sun_irradiance_rgb": [0, 0, 0], "sky_irradiance_rgb": [60, 90, 120], "sky_shape": {"uniform": [0.5, 0.5, 0.5], "overcast": [0.5, 0.5, 0.5]}})"
      "\n"
      R"({"frame": 1, "sun_irradiance_rgb": [0, 0, 0], "sky_irradiance_rgb": [60, 90, 120], "sky_shape": {"clear": [1, 1, 1]}})"
      "\n");
  const std::string second = Write(
      "second.jsonl",
      R"({"frame": 1, "sun_irradiance_rgb": [0, 0, 0], "sky_irradiance_rgb": [60, 90, 120], "sky_shape": {"clear": [1, 1, 1]}})"
      "\n");
  for (const ObjectLight light : {ObjectLight::kGather, ObjectLight::kVolume}) {
    options_.pipeline.object_light.route = light;
    options_.pipeline.effects = EffectSettings::Everything();
    options_.pipeline.effects[Effect::kLightUpdate] = EffectSwitch::kOff;
    RunRunCommand(options_);
    const auto records = ReadLightingRecords(options_.out / "lighting.jsonl");
    ASSERT_FALSE(records.at(1).error) << *records.at(1).error;
    RunCommandOptions alone = options_;
    alone.lighting = second;
    alone.out = folder_ / "alone";
    RunRunCommand(alone);
    EXPECT_EQ(ReadRadianceImage(options_.out / "composite/000001.exr").pixels,
              ReadRadianceImage(alone.out / "composite/000001.exr").pixels);
  }
}

// A frame without a finite pixel fails alone; a pixel that is too bright to be written, and one
// that is none, are counted.
TEST_F(RunCommand, BadPixelsEndNoRun) {
  const fs::path sequence = folder_ / "sequence";
  fs::copy(options_.sequence, sequence, fs::copy_options::recursive);
  RgbImage picture = ReadRadianceImage(sequence / "frames/000000.exr");
  const float nan = std::nanf("");
  picture.At(3, 3) = {1.0f, 1e5f, 2.0f};
  picture.At(5, 3) = {1.0f, nan, 2.0f};
  WriteExr(sequence / "frames/000000.exr", picture, ExrPrecision::kFloat);
  WriteExr(sequence / "frames/000001.exr",
           RgbImage(picture.width, picture.height, glm::vec3(nan)),
           ExrPrecision::kHalf);
  options_.sequence = sequence;
  RunRunCommand(options_);
  const auto records = ReadLightingRecords(options_.out / "lighting.jsonl");
  ASSERT_FALSE(records.at(0).error) << *records[0].error;
  const RgbImage composite = ReadRadianceImage(options_.out / "composite/000000.exr");
  EXPECT_EQ(composite.At(3, 3), glm::vec3(1.0f, 65504.0f, 2.0f));
  EXPECT_TRUE(std::isnan(composite.At(5, 3).g));
  ASSERT_TRUE(records.at(1).error);
  EXPECT_THAT(*records[1].error, HasSubstr("000001.exr: expected finite radiances, found none"));
  std::ifstream plan(options_.out / "plan.jsonl");
  std::string line;
  std::getline(plan, line);
  EXPECT_THAT(line, HasSubstr(R"("pixels_not_finite":1,"pixels_clamped":1)"));
}

// What `site check` says of units, a run says too; and what its frames were.
TEST_F(RunCommand, SaysThatAnObjectIsNotInMetres) {
  const fs::path sequence = folder_ / "sequence";
  fs::copy(options_.sequence, sequence, fs::copy_options::recursive);
  std::ifstream stream(sequence / "sequence.json");
  nlohmann::json json = nlohmann::json::parse(stream);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      auto& value = json.at("virtual_object").at("world_from_object").at(row).at(column);
      value = 100.0 * value.get<double>();
    }
  }
  std::ofstream(sequence / "sequence.json") << json;
  options_.sequence = sequence;
  RunRunCommand(options_);
  const std::string report = ContentOf(options_.out / "report.html");
  EXPECT_THAT(report, HasSubstr("the virtual object seems not to be in metres"));
  EXPECT_THAT(report, HasSubstr("frames linear, "));
}

// No file may grow beyond half of what the report's pictures take: they are kept in memory, and
// left out in the end.
TEST_F(RunCommand, ItsReportsPicturesEndNoRunWhereTheDiskIsFull) {
  options_.lighting.clear();
  options_.written = WrittenPictures::kNone;
  RunRunCommand(options_);
  const auto records = ReadLightingRecords(options_.out / "lighting.jsonl");
  EXPECT_THAT(ContentOf(options_.out / "report.html"), HasSubstr("data:image/jpeg"));
  {
    const FileSizeLimit limit(fs::file_size(options_.out / "report.html") * 3 / 4 / 2);
    RunRunCommand(options_);
  }
  const auto again = ReadLightingRecords(options_.out / "lighting.jsonl");
  ASSERT_EQ(again.size(), records.size());
  for (const auto& record : again) EXPECT_FALSE(record.error) << *record.error;
  const std::string plan = ContentOf(options_.out / "plan.jsonl");
  EXPECT_EQ(std::count(plan.begin(), plan.end(), '\n'), static_cast<long>(records.size()));
  const std::string report = ContentOf(options_.out / "report.html");
  EXPECT_THAT(report, testing::EndsWith("</html>\n"));
  EXPECT_THAT(report, HasSubstr("the report is without pictures: "));
  EXPECT_THAT(report, testing::Not(HasSubstr("data:image/jpeg")));
  EXPECT_THAT(report, HasSubstr("<svg"));
  EXPECT_THAT(ContentOf(options_.out / "events.jsonl"), HasSubstr("pictures are kept in memory"));
}

TEST_F(RunCommand, LeavesNothingOfAnEarlierRunAndAllElse) {
  for (const char* old : {"composite/000099.png", "sky/000099.exr", "environment/000099.exr"}) {
    fs::create_directories((options_.out / old).parent_path());
    Write(fs::path("out") / old, "of an earlier run");
  }
  Write("out/lighting.jsonl", "of an earlier run");
  Write("out/notes.txt", "mine");
  Write("out/environment/survey.exr", "mine too");
  RunRunCommand(options_);
  EXPECT_FALSE(fs::exists(options_.out / "composite/000099.png"));
  EXPECT_FALSE(fs::exists(options_.out / "sky/000099.exr"));
  EXPECT_FALSE(fs::exists(options_.out / "environment/000099.exr"));
  EXPECT_TRUE(fs::exists(options_.out / "environment/survey.exr"));
  EXPECT_TRUE(fs::exists(options_.out / "sky/000001.exr"));
  EXPECT_TRUE(fs::exists(options_.out / "notes.txt"));
}

TEST_F(RunCommand, RefusesLightThatItWouldRemove) {
  fs::create_directories(options_.out / "sky");
  fs::copy(options_.lighting, options_.out / "lighting.jsonl");
  fs::copy(folder_ / "east.exr", options_.out / "east.exr");
  fs::copy(folder_ / "east.exr", options_.out / "sky/000000.exr");
  const std::string by_image =
      R"({"frame": 0, "sun_irradiance_rgb": [0, 0, 0], "sky_irradiance_rgb": [1, 1, 1], )"
      R"("sky_image": "out/sky/000000.exr"})";
  for (const fs::path& light : {options_.out / "lighting.jsonl", Write("by.jsonl", by_image)}) {
    options_.lighting = light;
    const std::string refusal = Refusal(
        +[](const RunCommandOptions& options) {
          RunRunCommand(options);
          return std::string();
        },
        options_);
    EXPECT_THAT(refusal, HasSubstr("expected another folder")) << light;
    EXPECT_TRUE(fs::exists(light));
    EXPECT_TRUE(fs::exists(options_.out / "sky/000000.exr"));
  }
}

}  // namespace
}  // namespace pleinair::run_command_test
