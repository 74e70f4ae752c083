// A complete score, of the bundled sequence and a run made up from its truth.
#include "datasets/scoring.h"

#include <chrono>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calib/response.h"
#include "datasets/frame_source.h"
#include "datasets/lighting_record.h"
#include "datasets/video/video_writer.h"
#include "scene/frame.h"
#include "scene/image_io.h"
#include "sunmodel/time_text.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::scoring_test {
namespace {

namespace fs = std::filesystem;

const fs::path kBundled = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

class ScoringTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(out_ / "composite");
    fs::create_directories(out_ / "mask");
  }
  // The truth as if it were an estimate, the sun `sun_scale` times as strong.
  static nlohmann::json Line(const TruthFrame& truth, double sun_scale) {
    const auto list = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    nlohmann::json light = {{"sun_direction_enu", list(truth.sun_direction_enu)},
                            {"sun_irradiance_rgb", list(sun_scale * truth.sun_irradiance_rgb)},
                            {"sky_irradiance_rgb", list(truth.sky_irradiance_rgb)},
                            {"sun_irradiance_stddev_rgb", {50.0, 50.0, 50.0}},
                            {"sky_irradiance_stddev_rgb", nullptr}};
    nlohmann::json line = light;
    line["raw"] = light;
    line["frame"] = truth.frame;
    line["sky_shape"] = {{"uniform", {1, 1, 1}}};
    return line;
  }
  void WriteLighting(const std::vector<nlohmann::json>& lines) {
    std::ofstream stream(out_ / "lighting.jsonl");
    for (const nlohmann::json& line : lines) stream << line.dump() << "\n";
  }
  std::string Refusal() {
    try {
      ScoreRun(kBundled, out_);
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "accepted";
  }

  TemporaryFolder folder_;
  fs::path out_ = folder_ / "out";
};

TEST_F(ScoringTest, FindsNoFaultWithTheTruth) {
  const std::vector<TruthFrame> truth = ReadTruth(ReadSequence(kBundled));
  std::vector<nlohmann::json> lines;
  for (const TruthFrame& frame : truth) {
    lines.push_back(Line(frame, 1.0));
    if (!frame.with_object) continue;
    const std::string number = "00000" + std::to_string(frame.frame);
    fs::copy_file(*frame.with_object, out_ / "composite" / (number + ".exr"));
    // All is the composite's own.
    WritePng(out_ / "mask" / (number + ".png"), Gray8Image(480, 360, 255));
  }
  WriteLighting(lines);
  const Score score = ScoreRun(kBundled, out_);
  ASSERT_EQ(score.frames.size(), 6u);
  EXPECT_NEAR(score.raw.all.sun_error->largest, 0.0, 1e-12);
  EXPECT_NEAR(score.light.all.sky_error->largest, 0.0, 1e-12);
  EXPECT_EQ(score.light.all.frames, 6);
  EXPECT_FALSE(score.raw.all.sky_sigma);
  EXPECT_EQ(score.composite.object_psnr_db->count, 4);
  EXPECT_EQ(score.composite.object_psnr_db->smallest, kHighestPsnrDb);
  EXPECT_EQ(score.composite.effect_psnr_db->smallest, kHighestPsnrDb);
  EXPECT_EQ(score.composite.changed_of_unchanged->largest, 0.0);
  EXPECT_FALSE(score.composite.object_psnr_without_specular_db);
  EXPECT_GT(score.frames[0].composite->object_pixels, 1000);
  EXPECT_GT(score.frames[0].composite->effect_pixels, 1000);
  // Frames 1 and 3 have no picture with the object: said, not dropped.
  EXPECT_EQ(score.frames[1].without,
            std::vector<std::string>{"composite: no truth with the object"});
  const std::string table = ToTable(score);
  EXPECT_NE(table.find("no truth with the object: frame 1, 3"), std::string::npos) << table;
  const nlohmann::json json = nlohmann::json::parse(ToJson(score));
  EXPECT_EQ(json["frames"].size(), 6u);
  EXPECT_EQ(json["composite"]["object_psnr_db"]["median"], kHighestPsnrDb);
  EXPECT_TRUE(json["frames"][1]["composite"].is_null());
}

// The unchanged camera picture is bit-identical everywhere, and lacks the object and its shadow.
TEST_F(ScoringTest, SeesThatAnEmptyCompositeLacksTheObject) {
  const Sequence sequence = ReadSequence(kBundled);
  std::vector<nlohmann::json> lines;
  for (const TruthFrame& frame : ReadTruth(sequence)) lines.push_back(Line(frame, 1.1));
  WriteLighting(lines);
  fs::copy_file(kBundled / "frames/000000.exr", out_ / "composite/000000.exr");
  WritePng(out_ / "mask/000000.png", Gray8Image(480, 360, 0));
  const Score score = ScoreRun(kBundled, out_);
  const FrameScore& frame = score.frames[0];
  ASSERT_TRUE(frame.composite);
  EXPECT_TRUE(frame.made_from_linear);
  EXPECT_LT(*frame.composite->object_psnr_db, 20.0);
  EXPECT_LT(*frame.composite->effect_psnr_db, 20.0);
  EXPECT_EQ(frame.composite->identical_outside_mask, 1.0);
  EXPECT_EQ(frame.composite->changed_of_unchanged, 0.0);
  EXPECT_NE(score.frames[2].without.at(0).find("composite/000002.exr is not there"),
            std::string::npos);
  // 10 % of each frame's sun, over the brightest frame's.
  EXPECT_NEAR(score.raw.all.sun_error->largest, 0.1, 1e-9);
  EXPECT_EQ(score.frames[2].raw->sun_error, 0.0);  // Overcast: there is none.
}

// A phone's recording: codes of unknown exposure, as a picture or in a video, and the truth as the
// phone shows it.
class OfAPhone : public ScoringTest, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(Pictures, OfAPhone, testing::Bool());
TEST_P(OfAPhone, IsComparedWithTheCamerasOwnPictureOfTheObject) {
  const bool is_video = GetParam();
  const fs::path folder = out_ / "phone";
  fs::copy(kBundled, folder, fs::copy_options::recursive);
  const RgbImage linear = ReadRadianceImage(folder / "frames/000000.exr");
  const double exposure = ReadSequence(folder).frames[0].EffectiveExposure().value();
  fs::remove_all(folder / "frames");
  fs::remove_all(folder / "truth/with_object");
  fs::create_directories(folder / "truth/with_object_ldr");
  const Rgb8Image codes = CodesFromRadiance(linear, ResponseCurve::Srgb(), exposure);
  WritePng(folder / "000000.png", codes);
  if (is_video) {
    VideoWriter(folder / "video.mkv", {VideoCodec::kFfv1, codes.width, codes.height, false, {}})
        .Add(codes, {});
  }
  WritePng(folder / "truth/with_object_ldr/000000.png", codes);
  for (const char* file : {"sequence.json", "truth/truth.json"}) {
    nlohmann::json document = nlohmann::json::parse(std::ifstream(folder / file));
    nlohmann::json first = document["frames"][0];
    if (first.contains("image")) {
      first.erase("image");
      first.erase("exposure");
      first["image_ldr"] = is_video ? "video.mkv" : "000000.png";
      if (is_video) first["video_frame"] = 0;
    }
    document["frames"] = nlohmann::json::array({first});
    std::ofstream(folder / file) << document.dump();
  }
  // A composite without any object is then the truth, within the codes' half precision.
  const Sequence sequence = ReadSequence(folder);
  const auto frame = MakeRecordedFrameSource(sequence, FrameKind::kLdr)->Next();
  WriteExr(out_ / "composite/000000.exr", frame->value().radiance, ExrPrecision::kHalf);
  nlohmann::json line = Line(ReadTruth(sequence)[0], 3.0);
  line["units"] = "relative per frame";
  WriteLighting({line});
  const Score score = ScoreRun(folder, out_);
  ASSERT_TRUE(score.frames[0].composite) << score.frames[0].without.at(0);
  EXPECT_FALSE(score.frames[0].made_from_linear);
  EXPECT_GT(*score.frames[0].composite->object_psnr_db, 60.0);
  EXPECT_FALSE(score.raw.all.sun_error);
  EXPECT_NEAR(score.raw.all.sun_to_sky_error->median, 2.0, 1e-9);
}

TEST_F(ScoringTest, NamesFramesThatFailedOrAreMissing) {
  const std::vector<TruthFrame> truth = ReadTruth(ReadSequence(kBundled));
  WriteLighting({Line(truth[0], 1.0), {{"frame", 1}, {"error", "too dark"}}});
  const Score score = ScoreRun(kBundled, out_);
  EXPECT_EQ(score.frames[1].without.at(0), "all: the run failed on it: too dark");
  EXPECT_EQ(score.frames[2].without.at(0), "light: lighting.jsonl has no line for it");
  EXPECT_EQ(score.raw.all.frames, 1);
  EXPECT_NO_THROW(ToTable(score));
  EXPECT_NO_THROW(ToJson(score));
}

TEST_F(ScoringTest, RefusesTheRunOfAnotherSequence) {
  const Sequence sequence = ReadSequence(kBundled);
  nlohmann::json line = Line(ReadTruth(sequence)[0], 1.0);
  line["time_utc"] = "2020-06-21T10:00:00Z";
  WriteLighting({line});
  EXPECT_THAT(Refusal(),
              testing::HasSubstr("lighting.jsonl: frame 0: expected light of " +
                                 FormatUtcTime(sequence.frames[0].time) +
                                 ", found light of 2020-06-21T10:00:00Z"));
  line["time_utc"] = FormatUtcTime(sequence.frames[0].time + std::chrono::minutes(50));
  WriteLighting({line});
  EXPECT_EQ(Refusal(), "accepted") << "a clock that was put right";
}

TEST_F(ScoringTest, SaysWhichLineOfTheRunIsBad) {
  EXPECT_NE(Refusal().find("lighting.jsonl: expected"), std::string::npos);
  WriteLighting({{{"frame", 0}}, {{"frame", 0}}});
  EXPECT_NE(Refusal().find("lighting.jsonl:2: frame: expected each frame once"), std::string::npos);
  WriteLighting({{{"frame", 6}}});
  EXPECT_NE(Refusal().find("found frame 6"), std::string::npos);
  WriteLighting({{{"frame", 0}, {"raw", {{"sun_irradiance_rgb", {1, 2}}}}}});
  EXPECT_NE(Refusal().find("lighting.jsonl:1: raw.sun_irradiance_rgb: expected a list of 3"),
            std::string::npos);
  std::ofstream(out_ / "lighting.jsonl") << "{\"frame\": 0}\n{\"fra";
  EXPECT_NE(Refusal().find("lighting.jsonl:2: line 1, column"), std::string::npos);
}

TEST_F(ScoringTest, RefusesASequenceWithoutTruth) {
  const fs::path copy = out_ / "copy";
  fs::copy(kBundled, copy, fs::copy_options::recursive);
  fs::remove(copy / "truth/truth.json");
  try {
    ScoreRun(copy, out_);
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("truth.json: expected"), std::string::npos);
  }
  std::ofstream(copy / "truth/truth.json")
      << R"({"frames": [{"frame": 0, "sun_direction_enu": [0, 0, 1],
            "sun_irradiance_rgb": [1, 1, -1], "sky_irradiance_rgb": [1, 1, 1]}]})";
  try {
    ReadTruth(ReadSequence(copy));
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("frames[0].sun_irradiance_rgb[2]: expected"),
              std::string::npos)
        << error.what();
  }
}

TEST(LightingRecords, PassOverWhatASourceCannotKnow) {
  const fs::path file = fs::path(testing::TempDir()) / "pleinair_records.jsonl";
  std::ofstream(file) << R"({"frame": 2, "sun_irradiance_rgb": null, "error": null,)"
                      << R"( "sky_radiance_rgb": [[1, 2, 3]], "sun_observable": false})"
                      << "\n\n";
  const std::vector<LightingRecord> records = ReadLightingRecords(file);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].frame, 2);
  EXPECT_FALSE(records[0].error);
  EXPECT_FALSE(records[0].light.sun_irradiance_rgb);
  EXPECT_EQ(records[0].sun_observable, false);
  EXPECT_FALSE(records[0].raw);
  fs::remove(file);
}

}  // namespace
}  // namespace pleinair::scoring_test
