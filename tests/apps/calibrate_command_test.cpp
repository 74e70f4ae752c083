#include "apps/calibrate_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/fisheye_file.h"
#include "calib/response.h"
#include "scene/image_io.h"
#include "scene/srgb.h"
#include "sunmodel/angles.h"
#include "tests/calib/linear_from_code.h"
#include "tests/session/command_folder.h"

namespace pleinair::calibrate_command_test {
namespace {

using testing::HasSubstr;

const std::filesystem::path kShared = PLEINAIR_SHARED_DIR;

class CalibrateCommand : public CommandFolder {
 protected:
  // A levelled sky camera, as a map: north up, east right.
  std::filesystem::path WriteLens() {
    return Write(
        "sky.json",
        FisheyeCalibrationText(
            {CentredFisheye(FisheyeModel::kEquidistant, RadFromDeg(180.0), 512, 512), {}, {}, {}}));
  }
  // A ramp of 4 decades seen at four exposures by an sRGB camera.
  std::vector<std::filesystem::path> WriteBracket(const std::vector<double>& exposures) {
    RgbImage light(256, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 256; ++x) {
        light.At(x, y) =
            glm::vec3(static_cast<float>(std::pow(10.0, 4.0 * (x + y / 64.0) / 256.0 - 3.0)));
      }
    }
    std::vector<std::filesystem::path> files;
    for (const double exposure : exposures) {
      files.push_back(folder_ / (std::to_string(exposure) + ".png"));
      WritePng(files.back(), CodesFromRadiance(light, ResponseCurve::Srgb(), exposure));
    }
    return files;
  }
};

TEST_F(CalibrateCommand, FitsAResponseAndMergesWithIt) {
  const std::vector<double> exposures{8.0, 2.0, 0.5, 0.125};
  CalibrateResponseOptions response;
  response.pictures = WriteBracket(exposures);
  response.exposures = exposures;
  response.out = folder_ / "response.json";
  EXPECT_THAT(RunCalibrateResponse(response), HasSubstr("codes"));
  const ResponseCurve curve = ResponseCurve::FromFile(response.out);
  const float at_128 = LinearFromCode(curve, glm::u8vec3(128)).x;
  for (const int code : {20, 60, 200, 240}) {
    EXPECT_NEAR(LinearFromCode(curve, glm::u8vec3(static_cast<std::uint8_t>(code))).x / at_128,
                LinearFromSrgb(code / 255.0) / LinearFromSrgb(128 / 255.0),
                0.03 * LinearFromSrgb(code / 255.0) / LinearFromSrgb(128 / 255.0));
  }

  CalibrateMergeOptions merge;
  merge.pictures = response.pictures;
  merge.exposures = exposures;
  merge.out = folder_ / "merged.exr";
  EXPECT_THAT(RunCalibrateMerge(merge), HasSubstr("clipped in all of them"));
  const RgbImage merged = ReadRadianceImage(merge.out);
  // Light 1 at three quarters of the ramp; a code of rounding is 1 %.
  EXPECT_NEAR(merged.At(192, 0).x, 1.0f, 0.01f);

  merge.out = folder_ / "merged.png";
  EXPECT_THAT(Refusal(RunCalibrateMerge, merge), HasSubstr(".exr or .hdr"));
  response.exposures.pop_back();
  EXPECT_THAT(Refusal(RunCalibrateResponse, response), HasSubstr("--exposures"));
  response.exposures.clear();
  EXPECT_THAT(Refusal(RunCalibrateResponse, response), HasSubstr("EXIF"));
  response.pictures = {folder_ / "absent.jpg", folder_ / "missing.jpg"};
  EXPECT_THAT(Refusal(RunCalibrateResponse, response), HasSubstr("found nothing"));
}

// Pictures that were not taken of one view, too few to be compared.
TEST_F(CalibrateCommand, WritesACurveThatIsNoCamerasOnlyWhereForced) {
  CalibrateResponseOptions response;
  response.exposures = {8.0, 2.0, 0.5};
  response.pictures = WriteBracket(response.exposures);
  response.out = folder_ / "response.json";
  const std::string report = RunCalibrateResponse(response);
  EXPECT_THAT(report, HasSubstr("not compared: too few pictures"));
  EXPECT_THAT(report, testing::Not(HasSubstr("scatters")));

  Rgb8Image elsewhere = ReadDisplayImage(response.pictures[1]);
  std::reverse(elsewhere.pixels.begin(), elsewhere.pixels.end());
  WritePng(response.pictures[1], elsewhere);
  response.out = folder_ / "doubtful.json";
  EXPECT_THAT(Refusal(RunCalibrateResponse, response),
              testing::AllOf(HasSubstr("off one curve: expected one view"),
                             HasSubstr("; --force writes it all the same")));
  EXPECT_FALSE(std::filesystem::exists(response.out));
  response.force = true;
  EXPECT_THAT(RunCalibrateResponse(response), HasSubstr("forced: response of "));
  EXPECT_TRUE(std::filesystem::exists(response.out));
}

TEST_F(CalibrateCommand, PutsTheResponseIntoASite) {
  const auto site = Write("site.json",
                          R"({"format": "pleinair-site", "version": 1, "note": "kept",
                              "radiometry": {"frames": "linear"}})");
  CalibrateResponseOptions response;
  response.exposures = {8.0, 2.0, 0.5, 0.125};
  response.pictures = WriteBracket(response.exposures);
  EXPECT_THAT(Refusal(RunCalibrateResponse, response), HasSubstr("--out or --site"));
  response.site = folder_;
  response.out = folder_ / "response.json";
  RunCalibrateResponse(response);
  std::ifstream stream(site);
  const nlohmann::json written = nlohmann::json::parse(stream);
  EXPECT_EQ(written["note"], "kept");
  EXPECT_EQ(written["radiometry"]["frames"], "linear");
  const glm::u8vec3 code(128);
  const ResponseCurve named =
      ResponseCurve::FromFile(folder_ / written["radiometry"]["frames_ldr"].get<std::string>());
  EXPECT_EQ(LinearFromCode(named, code),
            LinearFromCode(ResponseCurve::FromFile(response.out), code));
}

TEST_F(CalibrateCommand, AveragesFrames) {
  CalibrateAverageOptions average;
  for (const float value : {1.0f, 3.0f}) {
    average.frames.push_back(folder_ / (std::to_string(value) + ".exr"));
    WriteExr(average.frames.back(), RgbImage(4, 3, glm::vec3(value)), ExrPrecision::kFloat);
  }
  average.out = folder_ / "mean.hdr";
  EXPECT_THAT(RunCalibrateAverage(average), HasSubstr("2 frames"));
  EXPECT_EQ(ReadRadianceImage(average.out).At(0, 0), glm::vec3(2.0f));
  // The deviation of 1 and 3, sqrt(2), is 71 % of their mean.
  EXPECT_THAT(RunCalibrateAverage(average), HasSubstr("warning: the frames differ by 71 %"));
  average.frames[1] = folder_ / "1.2.exr";
  WriteExr(average.frames[1], RgbImage(4, 3, glm::vec3(1.2f)), ExrPrecision::kFloat);
  EXPECT_THAT(RunCalibrateAverage(average), testing::Not(HasSubstr("warning")));
  average.frames.push_back(folder_ / "5.exr");
  WriteExr(average.frames.back(), RgbImage(3, 3), ExrPrecision::kFloat);
  EXPECT_THAT(Refusal(RunCalibrateAverage, average), HasSubstr("5.exr: frame: expected 4x3"));
}

TEST_F(CalibrateCommand, TiesColoursByPairs) {
  CalibrateColourOptions colour;
  colour.calibration = WriteLens();
  colour.pairs = Write("pairs.csv", "# fish-eye, room\n1,1,1, 2,0.5,1\n0.5,0.2,0.1, 1,0.1,0.1\n");
  EXPECT_THAT(RunCalibrateColour(colour), HasSubstr("over 2 pairs"));
  const FisheyeCalibration tied = ReadFisheyeCalibration(colour.calibration);
  EXPECT_NEAR((*tied.room_from_fisheye_rgb)[0][0], 2.0, 1e-12);
  EXPECT_NEAR((*tied.room_from_fisheye_rgb)[1][1], 0.5, 1e-12);
  colour.pairs = Write("bad.csv", "1,1,1,2,0.5\n");
  EXPECT_THAT(Refusal(RunCalibrateColour, colour), HasSubstr("line 1: expected 6 numbers"));
  colour.pairs = Write("bad.csv", "1,1,1,2,red,1\n");
  EXPECT_THAT(Refusal(RunCalibrateColour, colour), HasSubstr("found \"red\""));
}

// No factor fits both: 1 and 10 of the same colour.
TEST_F(CalibrateCommand, TiesColoursThatContradictEachOtherOnlyWhereForced) {
  CalibrateColourOptions colour;
  colour.calibration = WriteLens();
  colour.pairs = Write("pairs.csv", "1,1,1, 1,1,1\n1,1,1, 10,10,10\n");
  EXPECT_THAT(Refusal(RunCalibrateColour, colour),
              testing::AllOf(HasSubstr("the pairs contradict each other by 6"),
                             HasSubstr("; --force writes it all the same")));
  EXPECT_FALSE(ReadFisheyeCalibration(colour.calibration).room_from_fisheye_rgb);
  colour.force = true;
  EXPECT_THAT(RunCalibrateColour(colour), HasSubstr("forced: the pairs contradict"));
  EXPECT_TRUE(ReadFisheyeCalibration(colour.calibration).room_from_fisheye_rgb);
}

// A camera whose red is half and whose blue is four fifths of the survey's: its response takes the
// factors, and codes then read as the survey's colours.
TEST_F(CalibrateCommand, TiesASitesCameraToTheSurvey) {
  const auto site = Write("site.json",
                          R"({"format": "pleinair-site", "version": 1, "note": "kept",
                              "camera": {"width": 40, "height": 20}})");
  RgbImage survey(40, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) {
      survey.At(x, y) = x < 20 ? glm::vec3(0.8f, 0.5f, 0.3f) : glm::vec3(0.3f, 0.4f, 0.6f);
    }
  }
  RgbImage seen = survey;
  for (glm::vec3& pixel : seen.pixels) pixel *= glm::vec3(0.5f, 1.0f, 0.8f);
  WriteExr(folder_ / "survey.exr", survey, ExrPrecision::kFloat);
  const Rgb8Image codes = CodesFromRadiance(seen, ResponseCurve::Srgb(), 1.0);
  WritePng(folder_ / "frame.png", codes);
  CalibrateColourOptions colour;
  colour.calibration = folder_;
  colour.from_picture = folder_ / "frame.png";
  colour.to_picture = folder_ / "survey.exr";
  colour.regions = Write("regions.csv", "8,8,4, 8,9,4\n30,10,4, 30,10,3\n");
  EXPECT_THAT(RunCalibrateColour(colour), HasSubstr("over 2 pairs"));
  std::ifstream stream(site);
  const nlohmann::json written = nlohmann::json::parse(stream);
  EXPECT_EQ(written["note"], "kept");
  const ResponseCurve tied =
      ResponseCurve::FromFile(folder_ / written["radiometry"]["frames_ldr"].get<std::string>());
  // Half a code at these values is 1 %.
  for (const int x : {5, 35}) {
    const glm::vec3 light = LinearFromCode(tied, codes.At(x, 10));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(light[c] / light[1], survey.At(x, 10)[c] / survey.At(x, 10)[1], 0.02);
    }
  }
  // Known colours in place of the other picture.
  colour.to_picture.clear();
  colour.regions = Write("known.csv", "8,8,4, 0.8,0.5,0.3\n30,10,4, 0.3,0.4,0.6\n");
  EXPECT_THAT(RunCalibrateColour(colour), HasSubstr("over 2 pairs"));
  colour.regions = Write("outside.csv", "80,8,4, 0.8,0.5,0.3\n");
  EXPECT_THAT(Refusal(RunCalibrateColour, colour), HasSubstr("region at 80,8"));
  colour.matrix = true;
  EXPECT_THAT(Refusal(RunCalibrateColour, colour), HasSubstr("--matrix"));
}

// The centre is the zenith, the middle of the top side north, of the right side east (as a map).
// As spreadsheets write it.
TEST_F(CalibrateCommand, ReadsATableThatBeginsWithAByteOrderMark) {
  CalibrateColourOptions colour;
  colour.calibration = WriteLens();
  colour.pairs = Write("pairs.csv",
                       "\xef\xbb\xbf"
                       "1,1,1,2,2,2\r\n2,2,2,4,4,4\r\n");
  EXPECT_THAT(RunCalibrateColour(colour), HasSubstr("over 2 pairs"));
}

TEST_F(CalibrateCommand, OrientsByMarks) {
  CalibrateOrientationOptions orientation;
  orientation.calibration = WriteLens();
  orientation.out = folder_ / "oriented.json";
  orientation.marks =
      Write("marks.csv", "255.5,255.5,0,0,1\n255.5,0,0,1,0.003\n511,255.5,1,0,0.003\n");
  orientation.mirrored = true;
  EXPECT_THAT(RunCalibrateOrientation(orientation), HasSubstr("rms 0.0"));
  const auto found = ReadFisheyeCalibration(orientation.out).world_from_camera.value();
  EXPECT_NEAR(found[0].x, 1.0, 1e-5);
  EXPECT_NEAR(found[1].y, -1.0, 1e-5);
  EXPECT_NEAR(found[2].z, 1.0, 1e-5);
  EXPECT_FALSE(ReadFisheyeCalibration(orientation.calibration).world_from_camera);

  orientation.marks = Write("marks.csv", "0,0,0,0,1\n255.5,0,0,1,0\n");
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation), HasSubstr("mark 0,0"));
  orientation.marks = Write("marks.csv", "255.5,255.5,0,0,1\n");
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation), HasSubstr("two suns or marks"));
  orientation.marks.clear();
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation), HasSubstr("--marks or --sun"));
  orientation.sun_pictures = {folder_ / "a.exr"};
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation), HasSubstr("--time"));
}

// A sun at another height than a levelled camera sees it, and pictures whose mirroring is not
// stated.
TEST_F(CalibrateCommand, WritesAnOrientationInDoubtOnlyWhereForced) {
  CalibrateOrientationOptions orientation;
  orientation.calibration = WriteLens();
  orientation.levelled = true;
  // 55 deg from the axis, and 18 deg from the zenith.
  orientation.marks = Write("marks.csv", "255.5,100,0,1,3\n");
  EXPECT_THAT(
      Refusal(RunCalibrateOrientation, orientation),
      testing::AllOf(HasSubstr("is off by 36."), HasSubstr("--site"), HasSubstr("--mirrored")));
  orientation.levelled = false;
  orientation.marks = Write("marks.csv", "255.5,0,0,1,0.003\n511,255.5,1,0,0.003\n");
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation),
              HasSubstr("the axis would be 179.5 deg from the zenith"));
  orientation.marks =
      Write("marks.csv", "255.5,255.5,0,0,1\n255.5,0,0,1,0.003\n511,255.5,1,0,0.003\n");
  EXPECT_THAT(Refusal(RunCalibrateOrientation, orientation),
              HasSubstr("2 of 3 suns or marks agree"));
  EXPECT_FALSE(ReadFisheyeCalibration(orientation.calibration).world_from_camera);
  orientation.force = true;
  EXPECT_THAT(RunCalibrateOrientation(orientation), HasSubstr("forced: 2 of 3"));
  EXPECT_TRUE(ReadFisheyeCalibration(orientation.calibration).world_from_camera);
}

// The recorded room's sky camera is stated to be levelled, north up: its suns agree to a tenth of a
// degree (a third of a pixel).
TEST_F(CalibrateCommand, OrientsByTheSunsOfARecording) {
  const std::filesystem::path fisheye = kShared / "sequences/room-window/fisheye";
  if (!std::filesystem::is_directory(fisheye)) GTEST_SKIP() << "no recordings in " << kShared;
  CalibrateOrientationOptions orientation;
  orientation.calibration = WriteLens();
  orientation.site = "50.3569,7.589,70";
  orientation.mirrored = true;
  orientation.sun_pictures = {
      fisheye / "000000.exr", fisheye / "000002.exr", fisheye / "000005.exr"};
  orientation.times = {"2007-03-20T08:40:00Z", "2007-03-20T10:50:00Z", "2007-03-20T13:20:00Z"};
  RunCalibrateOrientation(orientation);
  const auto found = ReadFisheyeCalibration(orientation.calibration).world_from_camera.value();
  EXPECT_NEAR(found[0].y, 0.0, RadFromDeg(0.1));
  EXPECT_NEAR(found[0].z, 0.0, RadFromDeg(0.1));
  EXPECT_NEAR(found[1].z, 0.0, RadFromDeg(0.1));
  EXPECT_GT(found[0].x, 0.999);
  EXPECT_LT(found[1].y, -0.999);
}

// The photograph's file is sRGB: its green channel follows that curve where the greys are bright,
// to 10 % (the darker ones are lifted by haze, and the light is not white).
TEST_F(CalibrateCommand, FitsAResponseToAChart) {
  const std::filesystem::path photo = kShared / "data/colorchecker/chart_photo_1.jpg";
  if (!std::filesystem::exists(photo)) GTEST_SKIP() << "no picture " << photo;
  CalibrateResponseOptions response;
  response.pictures = {photo};
  response.chart = true;
  for (const char* curve : {"monotone", "logarithmic"}) {
    response.curve = curve;
    response.out = folder_ / curve;
    RunCalibrateResponse(response);
    const ResponseCurve found = ResponseCurve::FromFile(response.out);
    const ResponseCurve srgb = ResponseCurve::Srgb();
    const glm::u8vec3 middle(100);
    for (const int code : {80, 130, 160, 200}) {
      const glm::u8vec3 codes(static_cast<std::uint8_t>(code));
      const float ratio = LinearFromCode(found, codes).y / LinearFromCode(found, middle).y;
      const float expected = LinearFromCode(srgb, codes).y / LinearFromCode(srgb, middle).y;
      EXPECT_NEAR(ratio / expected, 1.0f, 0.1f) << curve << " " << code;
    }
  }
  response.corners = "0,0,10,0,10,10";
  EXPECT_THAT(Refusal(RunCalibrateResponse, response), HasSubstr("8 numbers"));

  CalibrateColourOptions colour;
  colour.calibration = WriteLens();
  colour.from_picture = photo;
  colour.to_picture = photo;
  colour.matrix = true;
  RunCalibrateColour(colour);
  const auto matrix = ReadFisheyeCalibration(colour.calibration).room_from_fisheye_rgb.value();
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(matrix[c][r], c == r ? 1.0 : 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace pleinair::calibrate_command_test
