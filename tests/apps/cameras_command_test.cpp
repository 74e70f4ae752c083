#include "apps/cameras_command.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/scene/shell.h"

namespace pleinair::cameras_command_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

CameraList OneCamera() {
  CameraDescription camera;
  camera.device = "/dev/video7";
  camera.name = "Cam\x1b[31mera \xff";
  camera.identity = camera.name + "|usb-1.2\n";
  camera.driver = "uvcvideo";
  const PixelFormat yuyv = *PixelFormatNamed("YUYV");
  const PixelFormat nv12 = *PixelFormatNamed("NV12");
  const PixelFormat mjpeg = *PixelFormatNamed("MJPEG");
  camera.modes = {{yuyv, 640, 480, {30.0, 15.0}},
                  {yuyv, 320, 240, {30.0, 15.0}},
                  {yuyv, 1280, 720, {10.0}},
                  {mjpeg, 1920, 1080, {30000.0 / 1001.0}},
                  {mjpeg, 640, 480, {}},
                  {nv12, 640, 480, {30.0, 15.0}},
                  {nv12, 320, 240, {30.0, 15.0}},
                  {nv12, 1280, 720, {10.0}}};
  camera.controls = {{"Exposure Time, Absolute", 3.0, 2047.0, 250.0, 166.0, "100 us", false},
                     {"Gain", 0.0, 10.5, 1.25, 1.0, "", true}};
  return {{camera}, {"/dev/video8"}, ""};
}

TEST(CamerasCommand, ListsFormatsRatesAndControls) {
  const std::string text = CamerasText(OneCamera());
  EXPECT_THAT(text, HasSubstr("/dev/video7\n"));
  EXPECT_THAT(text,
              HasSubstr("  format    YUYV, NV12\n"
                        "            640x480, 320x240: 30, 15 Hz; 1280x720: 10 Hz\n"
                        "  format    MJPEG\n"
                        "            1920x1080: 29.97 Hz; 640x480: rate not stated\n"));
  EXPECT_THAT(text, HasSubstr("Exposure Time, Absolute [100 us]: 250, 3 to 2047, default 166\n"));
  EXPECT_THAT(text, HasSubstr("Gain: 1.25, 0 to 10.5, default 1, read only\n"));
  EXPECT_THAT(
      text,
      HasSubstr("\npassed over: /dev/video8: this user may not open it: join the group video"));
}

TEST(CamerasCommand, MakesControlCharactersVisible) {
  const std::string text = CamerasText(OneCamera());
  EXPECT_THAT(text, HasSubstr(R"(name      Cam\x1b[31mera \xff)"));
  EXPECT_THAT(text, HasSubstr(R"(|usb-1.2\x0a)"));
  const std::string json = CamerasJson(OneCamera());
  EXPECT_THAT(json, Not(HasSubstr("\x1b")));
  EXPECT_THAT(json, Not(HasSubstr("\xff")));
}

TEST(CamerasCommand, WritesTheSameAsJson) {
  const nlohmann::json report = nlohmann::json::parse(CamerasJson(OneCamera()));
  const nlohmann::json& camera = report.at("cameras").at(0);
  EXPECT_EQ(camera.at("device"), "/dev/video7");
  ASSERT_EQ(camera.at("modes").size(), 8u);
  const nlohmann::json first{
      {"format", "YUYV"}, {"width", 640}, {"height", 480}, {"frames_per_second", {30.0, 15.0}}};
  EXPECT_EQ(camera.at("modes").at(0), first);
  const nlohmann::json exposure{{"name", "Exposure Time, Absolute"},
                                {"minimum", 3.0},
                                {"maximum", 2047.0},
                                {"value", 250.0},
                                {"default", 166.0},
                                {"unit", "100 us"},
                                {"read_only", false}};
  EXPECT_EQ(camera.at("controls").at(0), exposure);
  EXPECT_EQ(report.at("passed_over").size(), 1u);
}

TEST(CamerasCommand, SaysInOneLineWhereItLookedWhenThereIsNone) {
  EXPECT_EQ(CamerasText({}),
            "no camera; looked at /dev/video0 to /dev/video255 (V4L2), libcamera\n");
  EXPECT_EQ(CamerasText({{}, {}, "not built in"}),
            "no camera; looked at /dev/video0 to /dev/video255 (V4L2), libcamera; libcamera: not "
            "built in\n");
  EXPECT_EQ(nlohmann::json::parse(CamerasJson({})).at("cameras").size(), 0u);
}

TEST(CamerasCommand, ListsTheStandIn) {
  const std::string command = std::string(PLEINAIR_STAND_IN) + " " + PLEINAIR_SOURCE_DIR +
                              "/datasets/samples/courtyard --rate 24 --number 17 -- " +
                              PLEINAIR_PROGRAM + " cameras --json";
  const Ended ended = StandardOutputOf(command);
  ASSERT_EQ(ended.exit_code, 0);
  const nlohmann::json report = nlohmann::json::parse(ended.output);
  const nlohmann::json* stand_in = nullptr;
  for (const nlohmann::json& camera : report.at("cameras")) {
    if (camera.at("device") == "/dev/video17") stand_in = &camera;
  }
  ASSERT_NE(stand_in, nullptr) << ended.output;
  EXPECT_EQ(stand_in->at("identity"), "pleinair stand-in|stand-in:17|0");
  const nlohmann::json& mode = stand_in->at("modes").at(0);
  EXPECT_EQ(mode.at("format"), "YUYV");
  EXPECT_EQ(mode.at("width"), 480);
  EXPECT_THAT(mode.at("frames_per_second").dump(), HasSubstr("24.0"));
}

// All of it: the report alone must be on the two streams together.
TEST(CamerasCommand, DoesNotShowWhatLibcameraLogs) {
  const Ended ended =
      Shell(std::string("LIBCAMERA_LOG_LEVELS='*:DEBUG' ") + PLEINAIR_PROGRAM + " cameras --json");
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_TRUE(nlohmann::json::accept(ended.output)) << ended.output;
}

}  // namespace
}  // namespace pleinair::cameras_command_test
