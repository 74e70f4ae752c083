#include "apps/sun_command.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pleinair::sun_command_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SunCommandOptions Golden() {
  SunCommandOptions options;
  options.site = "39.742476,-105.1786,1830.14";
  options.time = "2003-10-17T12:30:30-07:00";
  options.tt_minus_ut1_s = 67.0;
  options.pressure_hpa = 820.0;
  options.temperature_c = 11.0;
  options.json = true;
  return options;
}

nlohmann::json JsonOf(const SunCommandOptions& options) {
  return nlohmann::json::parse(RunSunCommand(options));
}

std::string ErrorOf(const SunCommandOptions& options) {
  try {
    RunSunCommand(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

// NREL/TP-560-34302 (Reda and Andreas), table A5.1. 0.0003 deg: polar motion and what that
// algorithm leaves out (diurnal aberration 0.0001).
TEST(SunCommand, AnswersThePublishedExample) {
  const nlohmann::json json = JsonOf(Golden());
  EXPECT_EQ(json.at("time_utc"), "2003-10-17T19:30:30Z");
  EXPECT_NEAR(json.at("azimuth_deg"), 194.340241, 0.0003);
  EXPECT_NEAR(json.at("elevation_deg"), 39.872046, 0.0003);
  EXPECT_NEAR(json.at("apparent_elevation_deg"), 39.888378, 0.0003);
  EXPECT_NEAR(json.at("angular_radius_deg"), 0.2675, 0.0002);
  EXPECT_NEAR(json.at("air_mass"), 1.557, 0.001);
  EXPECT_EQ(json.at("pressure_hpa"), 820.0);
  EXPECT_EQ(json.at("temperature_c"), 11.0);
  EXPECT_FALSE(json.contains("warning"));
}

TEST(SunCommand, HasNoAirMassAtNight) {
  SunCommandOptions night = Golden();
  night.time = "2003-10-17T07:30:30Z";
  EXPECT_TRUE(JsonOf(night).at("air_mass").is_null());
}

TEST(SunCommand, GivesDirectionsThatFitTheAngles) {
  const nlohmann::json json = JsonOf(Golden());
  const auto airless = json.at("direction_enu").get<std::vector<double>>();
  const auto apparent = json.at("apparent_direction_enu").get<std::vector<double>>();
  ASSERT_EQ(airless.size(), 3u);
  ASSERT_EQ(apparent.size(), 3u);
  const double degree = std::atan(1.0) / 45.0;
  EXPECT_NEAR(airless[2], std::sin(json.at("elevation_deg").get<double>() * degree), 1e-12);
  EXPECT_NEAR(
      apparent[2], std::sin(json.at("apparent_elevation_deg").get<double>() * degree), 1e-12);
  const double azimuth = json.at("azimuth_deg").get<double>() * degree;
  EXPECT_NEAR(std::atan2(airless[0], airless[1]), std::remainder(azimuth, 360.0 * degree), 1e-12);
  EXPECT_NEAR(std::atan2(apparent[0], apparent[1]), std::remainder(azimuth, 360.0 * degree), 1e-12);
}

TEST(SunCommand, SaysWhenNothingRises) {
  SunCommandOptions options = Golden();
  options.site = "78.22,15.65";
  options.time = "2020-12-21T12:00:00Z";
  const nlohmann::json json = JsonOf(options);
  EXPECT_TRUE(json.at("sunrise_utc").is_null());
  EXPECT_TRUE(json.at("sunset_utc").is_null());
  EXPECT_EQ(json.at("solar_day"), "down all day");
  options.json = false;
  EXPECT_THAT(RunSunCommand(options), HasSubstr("none: down all day"));
}

TEST(SunCommand, TableHasUnitsAndEndsItsLines) {
  SunCommandOptions options = Golden();
  options.json = false;
  const std::string table = RunSunCommand(options);
  for (const char* part : {"azimuth",
                           "194.340",
                           "apparent elevation",
                           "deg",
                           "hPa",
                           "air mass",
                           "W/m2",
                           "sunrise",
                           "2003-10-17T13:1",
                           "solar noon",
                           "sunset"}) {
    EXPECT_THAT(table, HasSubstr(part));
  }
  EXPECT_EQ(table.back(), '\n');
  EXPECT_THAT(table, Not(HasSubstr(" \n")));
}

TEST(SunCommand, WarnsOutsideTheSpanOfTheEphemeris) {
  SunCommandOptions options = Golden();
  EXPECT_FALSE(SunCommandWarning(options));
  options.time = "2150-06-21T12:00:00Z";
  ASSERT_TRUE(SunCommandWarning(options));
  EXPECT_THAT(*SunCommandWarning(options), HasSubstr("2150-06-21T12:00:00Z"));
  EXPECT_THAT(JsonOf(options).at("warning").get<std::string>(), HasSubstr("1900 to 2100"));
}

TEST(SunCommand, NamesWhatIsWrong) {
  SunCommandOptions options = Golden();
  options.site = "91,0";
  EXPECT_THAT(ErrorOf(options), HasSubstr("latitude is 91"));
  options = Golden();
  options.time = "noon";
  EXPECT_THAT(ErrorOf(options), HasSubstr("time 'noon'"));
  options = Golden();
  options.pressure_hpa = 101325.0;
  EXPECT_THAT(ErrorOf(options), HasSubstr("pressure_hpa is 101325"));
  options = Golden();
  options.tt_minus_ut1_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf(options), HasSubstr("tt_minus_ut1_s is nan"));
}

}  // namespace
}  // namespace pleinair::sun_command_test
