#include "datasets/fisheye_setup.h"

#include <limits>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/fisheye_file.h"
#include "datasets/frame_source.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"
#include "sunmodel/refraction.h"
#include "sunmodel/sun_position.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::fisheye_setup_test {
namespace {

class FisheyeSetupTest : public SequenceFolder {
 protected:
  // The refusal when the calibration says `fresh` where it said `old`.
  std::string RefusalOfCalibration(const std::string& old, const std::string& fresh) {
    std::string text = kFisheyeCalibration;
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    Write(folder_ / "fisheye.json", text.replace(at, old.size(), fresh));
    return Refusal(Everything());
  }
};

TEST_F(FisheyeSetupTest, TakesLensAndOrientationFromTheCalibration) {
  nlohmann::json document = Everything();
  for (const char* key : {"up", "image_up", "image_right"}) document["fisheye"].erase(key);
  document["fisheye"]["fov_deg"] = 170;
  WriteDocument(document);
  const Sequence sequence = ReadSequence(folder_);
  const FisheyeSetup setup = MakeFisheyeSetup(*sequence.fisheye, folder_);
  EXPECT_EQ(setup.camera.intrinsics.fx_px, 159.0);
  EXPECT_NEAR(FisheyeLens(setup.camera.intrinsics).MaxAngleRad(), 1.4835299, 1e-6);
  EXPECT_EQ(setup.camera.world_from_camera[1], glm::dvec3(0.0, -1.0, 0.0));
  EXPECT_LT(glm::determinant(setup.camera.world_from_camera), 0.0);
}

TEST_F(FisheyeSetupTest, TakesThemFromTheWordsWithoutACalibration) {
  nlohmann::json document = Everything();
  document["fisheye"].erase("calibration");
  WriteDocument(document);
  const FisheyeSetup setup = MakeFisheyeSetup(*ReadSequence(folder_).fisheye, folder_);
  EXPECT_EQ(setup.camera.intrinsics.cy_px, 249.5);
  EXPECT_EQ(setup.camera.world_from_camera[0], glm::dvec3(1.0, 0.0, 0.0));
  EXPECT_EQ(setup.camera.world_from_camera[1], glm::dvec3(0.0, -1.0, 0.0));
  EXPECT_EQ(setup.camera.world_from_camera[2], glm::dvec3(0.0, 0.0, 1.0));
}

TEST_F(FisheyeSetupTest, TakesACalibratedLens) {
  FisheyeCalibration calibration;
  calibration.intrinsics.model = FisheyeModel::kOpenCv;
  calibration.intrinsics.width_px = 512;
  calibration.intrinsics.height_px = 500;
  calibration.intrinsics.fx_px = calibration.intrinsics.fy_px = 160.0;
  calibration.intrinsics.cx_px = calibration.intrinsics.cy_px = 250.0;
  calibration.intrinsics.distortion = {-0.01, 0.002, -0.0003, 0.0};
  Write(folder_ / "fisheye.json", FisheyeCalibrationText(calibration));
  nlohmann::json document = Everything();
  document["fisheye"]["model"] = "opencv";
  document["fisheye"]["fov_deg"] = 190;
  WriteDocument(document);
  const FisheyeSetup setup = MakeFisheyeSetup(*ReadSequence(folder_).fisheye, folder_);
  EXPECT_EQ(setup.camera.intrinsics.distortion, calibration.intrinsics.distortion);
  EXPECT_NEAR(FisheyeLens(setup.camera.intrinsics).MaxAngleRad(), RadFromDeg(95.0), 1e-12);
  EXPECT_EQ(setup.camera.world_from_camera[2], glm::dvec3(0.0, 0.0, 1.0)) << "from the words";
}

TEST_F(FisheyeSetupTest, RefusesWhatDoesNotGoTogether) {
  EXPECT_NE(RefusalOfCalibration("equidistant", "equisolid").find("fisheye.calibration: expected"),
            std::string::npos);
  EXPECT_NE(RefusalOfCalibration("512", "640").find("fisheye.calibration: expected"),
            std::string::npos);
  // East where the words say north.
  EXPECT_NE(RefusalOfCalibration("[[1, 0, 0], [0, -1, 0]", "[[0, -1, 0], [-1, 0, 0]")
                .find("fisheye.image_up: expected"),
            std::string::npos);
  EXPECT_NE(RefusalOfCalibration("\"fx\": 159", "\"fx\": 0").find("fisheye.json: fx: expected"),
            std::string::npos);
  Write(folder_ / "fisheye.json", kFisheyeCalibration);

  nlohmann::json document = Everything();
  document["fisheye"].erase("calibration");
  for (const char* key : {"up", "image_up", "image_right"}) {
    nlohmann::json broken = document;
    broken["fisheye"].erase(key);
    EXPECT_NE(Refusal(broken).find("fisheye." + std::string(key) + ": expected"),
              std::string::npos);
    broken["fisheye"][key] = "upwards";
    EXPECT_NE(Refusal(broken).find("fisheye." + std::string(key) + ": expected"),
              std::string::npos);
  }
  document["fisheye"]["image_right"] = "-Y south";
  EXPECT_NE(Refusal(document).find("perpendicular"), std::string::npos);
  document = Everything();
  document["fisheye"]["model"] = "opencv";
  EXPECT_NE(Refusal(document).find("fisheye.calibration: expected"), std::string::npos);
  document["fisheye"].erase("calibration");
  EXPECT_NE(Refusal(document).find("fisheye.calibration: expected"), std::string::npos);
}

// After `calibrate lens`, before `calibrate orientation`: the site is read until a picture needs
// it.
TEST_F(FisheyeSetupTest, NeedsAnOrientationWhereFramesHavePictures) {
  nlohmann::json document = Everything();
  document["fisheye"].erase("calibration");
  for (const char* key : {"up", "image_up", "image_right"}) document["fisheye"].erase(key);
  EXPECT_NE(Refusal(document).find("fisheye.up: expected"), std::string::npos);
  for (nlohmann::json& frame : document["frames"]) frame.erase("fisheye");
  WriteDocument(document);
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_TRUE(sequence.fisheye);
  EXPECT_NO_THROW(MakeRecordedFrameSource(sequence, FrameKind::kLinear));
  // What is stated is checked all the same.
  document["fisheye"]["up"] = "upwards";
  EXPECT_NE(Refusal(document).find("fisheye.up: expected"), std::string::npos);
  document["fisheye"].erase("up");
  document["fisheye"]["model"] = "opencv";
  EXPECT_NE(Refusal(document).find("fisheye.calibration: expected"), std::string::npos);
}

class FisheyeFrames : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    const RgbImage view(8, 6, glm::vec3(1.0f));
    WriteExr(folder_ / "frames/0.exr", view, ExrPrecision::kHalf);
    WritePng(folder_ / "frames/1.png", Rgb8Image(8, 6, glm::u8vec3(100)));
    sky_ = RgbImage(512, 500, glm::vec3(0.5f, 1.0f, 2.0f));
    sky_.At(7, 3) = glm::vec3(1e7f, 1e7f, 2e7f);
  }

  std::string FirstReason() {
    const auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
    const auto first = source->Next();
    const auto second = source->Next();
    EXPECT_TRUE(second && second->has_value()) << "the next frame is not lost";
    return first->has_value() ? "read" : first->error().reason;
  }

  RgbImage sky_;
};

TEST_F(FisheyeFrames, CarryTheSkyWhereTheyHaveOne) {
  for (const std::string file : {"frames/f0.exr", "frames/f0.hdr"}) {
    file.ends_with("exr") ? WriteExr(folder_ / file, sky_, ExrPrecision::kFloat)
                          : WriteHdr(folder_ / file, sky_);
    nlohmann::json document = Everything();
    document["frames"][0]["fisheye"] = file;
    WriteDocument(document);
    const auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
    const auto with = source->Next();
    ASSERT_TRUE(with && with->has_value()) << with->error().reason;
    ASSERT_TRUE((*with)->fisheye_radiance);
    EXPECT_EQ((*with)->fisheye_radiance->width, 512);
    EXPECT_EQ((*with)->fisheye_radiance->At(0, 0), glm::vec3(0.5f, 1.0f, 2.0f));
    EXPECT_NEAR((*with)->fisheye_radiance->At(7, 3).z, 2e7f, 2e7f / 256.0f);
    const auto without = source->Next();
    ASSERT_TRUE(without && without->has_value());
    EXPECT_FALSE((*without)->fisheye_radiance);
  }
}

TEST_F(FisheyeFrames, AreTiedInColourByTheCalibration) {
  std::string text = kFisheyeCalibration;
  text.insert(text.find("\"fov_deg\""),
              "\"room_from_fisheye_rgb\": [[2, 0, 0], [0, 1, 0.25], [0, 0, 0.5]], ");
  Write(folder_ / "fisheye.json", text);
  WriteExr(folder_ / "frames/f0.exr", sky_, ExrPrecision::kFloat);
  WriteDocument(Everything());
  const auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
  const auto frame = source->Next();
  ASSERT_TRUE(frame && frame->has_value());
  EXPECT_EQ((*frame)->fisheye_radiance->At(0, 0), glm::vec3(1.0f, 1.5f, 1.0f));
}

// A half float's infinite sun is still one, and no undefined number.
TEST_F(FisheyeFrames, KeepAnInfiniteSunWhereColoursAreTied) {
  std::string text = kFisheyeCalibration;
  text.insert(text.find("\"fov_deg\""),
              "\"room_from_fisheye_rgb\": [[2, 0, 0], [0, 1, 0], [0, 0, 0.5]], ");
  Write(folder_ / "fisheye.json", text);
  RgbImage sky = sky_;
  sky.At(7, 3) = glm::vec3(1e7f);
  sky.At(8, 3) = glm::vec3(std::numeric_limits<float>::infinity());
  WriteExr(folder_ / "frames/f0.exr", sky, ExrPrecision::kFloat);
  WriteDocument(Everything());
  const auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
  const auto frame = source->Next();
  ASSERT_TRUE(frame && frame->has_value());
  const RgbImage& read = (*frame)->fisheye_radiance.value();
  EXPECT_EQ(read.At(8, 3), glm::vec3(std::numeric_limits<float>::infinity()));
  EXPECT_EQ(read.At(7, 3), glm::vec3(2e7f, 1e7f, 5e6f));
}

TEST_F(FisheyeFrames, WithABrokenSkyAreThatFramesError) {
  WriteDocument(Everything());
  EXPECT_NE(FirstReason().find("f0.exr: expected an image file, found nothing"), std::string::npos);
  Write(folder_ / "frames/f0.exr", "");
  EXPECT_NE(FirstReason().find("f0.exr"), std::string::npos);
  WriteExr(folder_ / "frames/f0.exr", RgbImage(512, 500, glm::vec3(1e-40f)), ExrPrecision::kFloat);
  EXPECT_NE(FirstReason().find("expected a brightest pixel of 1e-30 or more, found one of 9.99"),
            std::string::npos)
      << FirstReason();
  WriteExr(folder_ / "frames/f0.exr", RgbImage(500, 512), ExrPrecision::kHalf);
  EXPECT_NE(FirstReason().find("f0.exr: expected 512x500 pixels, found 500x512"),
            std::string::npos);
  WriteExr(folder_ / "frames/f0.exr",
           RgbImage(512, 500, glm::vec3(std::numeric_limits<float>::infinity())),
           ExrPrecision::kHalf);
  EXPECT_NE(FirstReason().find("f0.exr: expected finite radiances, found none"), std::string::npos);
  WriteExr(folder_ / "frames/f0.exr", sky_, ExrPrecision::kFloat);
  std::filesystem::resize_file(folder_ / "frames/f0.exr",
                               std::filesystem::file_size(folder_ / "frames/f0.exr") / 2);
  EXPECT_NE(FirstReason().find("f0.exr"), std::string::npos);
  std::filesystem::remove(folder_ / "frames/f0.exr");
  std::filesystem::create_directory(folder_ / "frames/f0.exr");
  EXPECT_NE(FirstReason().find("something that is no file"), std::string::npos);
}

// The brightest pixel of the recorded room's sky pictures lies where place and time say the sun is:
// the stated formula is the one we use. Half a pixel of 180 / 512 degrees is 0.25 degrees along its
// diagonal, the disc's radius another 0.27.
TEST(RecordedFisheye, SeesTheSunWhereItIs) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no recordings in " << folder;
  const Sequence sequence = ReadSequence(folder);
  const FisheyeSetup setup = MakeFisheyeSetup(*sequence.fisheye, folder);
  const FisheyePixelTable table = MakeFisheyePixelTable(setup.camera);
  const SunPosition airless = ComputeSunPosition(*sequence.site, sequence.frames[1].time);
  const glm::dvec3 sun =
      ApparentDirection(airless.direction_enu, StandardAtmosphere(sequence.site->height_m));
  const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  source->Next();
  const auto frame = source->Next();
  ASSERT_TRUE(frame && frame->has_value());
  const RgbImage& sky = *(*frame)->fisheye_radiance;
  std::size_t brightest = 0;
  for (std::size_t i = 0; i < sky.pixels.size(); ++i) {
    if (sky.pixels[i].y > sky.pixels[brightest].y) brightest = i;
  }
  const glm::dvec3 seen(table.direction_world.pixels[brightest]);
  EXPECT_LT(glm::distance(seen, sun), RadFromDeg(0.55));
}

}  // namespace
}  // namespace pleinair::fisheye_setup_test
