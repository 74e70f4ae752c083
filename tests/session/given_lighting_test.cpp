#include "session/given_lighting.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/time_text.h"
#include "tests/session/command_folder.h"

namespace pleinair::given_lighting_test {
namespace {

using testing::HasSubstr;

const std::string kLight =
    R"("sun_irradiance_rgb": [900, 800, 700], "sky_irradiance_rgb": [60, 90, 160])";

class GivenLightingFile : public CommandFolder {
 protected:
  std::string RefusalOf(const std::string& text) {
    try {
      ReadGivenLighting(Write("lighting.jsonl", text));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(GivenLightingFile, IsOfItsSequence) {
  Sequence sequence;
  sequence.frames.resize(2);
  sequence.frames[1].time = ParseUtcTime("2005-06-21T10:00:00Z");
  const auto file =
      Write("lighting.jsonl",
            R"({"frame": 0, "note": "of no time", )" + kLight + "}\n" +
                R"({"frame": 1, "time_utc": "2005-06-21T13:00:00+02:00", )" + kLight + "}\n");
  EXPECT_NO_THROW(RequireLightingOf(sequence, file));
  sequence.frames[1].time += std::chrono::hours(3);
  try {
    RequireLightingOf(sequence, file);
    ADD_FAILURE() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("lighting.jsonl: frame 1: expected light of 2005-06-21T13"));
  }
}

TEST_F(GivenLightingFile, IsReadByFrame) {
  Write("sky.hdr", "not looked into yet");
  const auto by_frame = ReadGivenLighting(
      Write("lighting.jsonl",
            R"({"frame": 0, "error": "lens cap on"})"
            "\n"
            R"({"frame": 2, "sun_direction_enu": [0, -0.6, 0.8], )" +
                kLight +
                R"(, "sky_shape": {"clear": [1, 0.5, 0], "overcast": [0, 0.5, 1]}})"
                "\n"
                R"({"frame": 3, "sky_image": "sky.hdr", )" +
                kLight + "}\n"));
  ASSERT_EQ(by_frame.size(), 2u);
  const GivenLight& clear = by_frame.at(2);
  EXPECT_EQ(clear.sun_direction_enu, glm::dvec3(0.0, -0.6, 0.8));
  EXPECT_EQ(clear.sun_irradiance_rgb, glm::dvec3(900, 800, 700));
  EXPECT_EQ(clear.sky_shares.at("overcast"), glm::dvec3(0.0, 0.5, 1.0));
  EXPECT_EQ(by_frame.at(3).sky_image, folder_ / "sky.hdr") << "beside the file that names it";
  EXPECT_FALSE(by_frame.at(3).sun_direction_enu.has_value());
}

TEST_F(GivenLightingFile, IsRefusedWithFrameAndKey) {
  EXPECT_THAT(RefusalOf(R"({"frame": 1, "sky_irradiance_rgb": [1, 1, 1]})"),
              HasSubstr("frame 1: sun_irradiance_rgb"));
  EXPECT_THAT(RefusalOf(R"({"frame": 1, "sky_shape": {"plaid": [1, 1, 1]}, )" + kLight + "}"),
              HasSubstr("plaid: expected one of uniform, overcast, clear"));
  EXPECT_THAT(RefusalOf(R"({"frame": 1, "sky_image": "gone.exr", )" + kLight + "}"),
              HasSubstr("gone.exr"));
  EXPECT_THAT(RefusalOf(R"({"frame": 0, "error": "lens cap on"})"),
              HasSubstr("no frame has light"));
}

}  // namespace
}  // namespace pleinair::given_lighting_test
