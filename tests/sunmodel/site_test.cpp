#include "sunmodel/site.h"

#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/angles.h"

namespace pleinair::site_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Quoted(std::string_view text) {
  std::string quoted(1, '\'');
  quoted += text;
  quoted += '\'';
  return quoted;
}

template <typename Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(Site, ReadsDegreesAndMetres) {
  const Site golden = ParseSite("39.742476,-105.1786,1830.14");
  EXPECT_DOUBLE_EQ(golden.latitude_rad, RadFromDeg(39.742476));
  EXPECT_DOUBLE_EQ(golden.longitude_rad, RadFromDeg(-105.1786));
  EXPECT_EQ(golden.height_m, 1830.14);
  EXPECT_EQ(ParseSite("-33,18").height_m, 0.0);
  // As maps copy it.
  EXPECT_DOUBLE_EQ(ParseSite(" 57.0488, 9.9217 , 15").longitude_rad, RadFromDeg(9.9217));
}

TEST(Site, TakesItsOwnLimits) {
  ParseSite("90,360,1000000").Validate();
  ParseSite("-90,-360,-11000").Validate();
  Site{std::numbers::pi / 2.0, 1e6, -430.0}.Validate();
}

TEST(Site, NamesTextAndFieldOnBadText) {
  const struct {
    const char* text;
    const char* field;
  } cases[] = {
      {"", "expected LAT,LON"},
      {"57", "expected LAT,LON"},
      {"91,0", "latitude is 91"},
      {"-90.0001,0", "latitude is -90.0001"},
      {"nan,0", "latitude is 'nan'"},
      {"inf,0", "latitude is 'inf'"},
      {"57N,9", "latitude is '57N'"},
      {",9", "latitude is ''"},
      {"57,9 9", "longitude is '9 9'"},
      {"57,9E", "longitude is '9E'"},
      {"57,361", "longitude is 361"},
      {"57,9,", "height is ''"},
      {"57,9,15m", "height is '15m'"},
      {"57,9,2e6", "height is 2000000"},
      {"57,9,15,3", "height is '15,3'"},
  };
  for (const auto& c : cases) {
    EXPECT_THAT(ErrorOf([&] { ParseSite(c.text); }),
                AllOf(HasSubstr(Quoted(c.text)), HasSubstr(c.field)));
  }
}

TEST(Site, NamesFieldAndValueOnBadNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ErrorOf([] {
                Site{39.74, -1.8, 0.0}.Validate();
              }),
              HasSubstr("latitude_rad is 39.74"));
  EXPECT_THAT(ErrorOf([&] { Site{nan, 0.0, 0.0}.Validate(); }), HasSubstr("latitude_rad is nan"));
  EXPECT_THAT(ErrorOf([&] { Site{0.0, inf, 0.0}.Validate(); }), HasSubstr("longitude_rad is inf"));
  EXPECT_THAT(ErrorOf([&] { Site{0.0, 0.0, nan}.Validate(); }), HasSubstr("height_m is nan"));
  EXPECT_THAT(ErrorOf([&] {
                Site{0.0, 0.0, 0.0, nan}.Validate();
              }),
              HasSubstr("model_north_azimuth_rad is nan"));
  EXPECT_THAT(ErrorOf([] { Site{0.0, 0.0, 1.1e6}.Validate(); }), HasSubstr("height_m is 1100000"));
}

}  // namespace
}  // namespace pleinair::site_test
