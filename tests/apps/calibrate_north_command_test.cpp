#include "apps/calibrate_north_command.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pleinair::calibrate_north_command_test {
namespace {

CalibrateNorthOptions Courtyard() {
  CalibrateNorthOptions options;
  options.sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  options.json = true;
  return options;
}

// The recording's model has true north: treated as grid north, it is off by the convergence, and no
// more than three of its own standard deviations beside that.
TEST(CalibrateNorth, ReportsTheOffsetFromTheNorthThatIsSaid) {
  CalibrateNorthOptions options = Courtyard();
  options.model_north = NorthKind::kGrid;
  const auto report = nlohmann::json::parse(RunCalibrateNorth(options));
  ASSERT_TRUE(report.at("determined").get<bool>()) << report.dump(2);
  const double convergence_deg = report.at("model_north_azimuth_deg").get<double>();
  // 0.92 deg east of the zone's middle, 57 deg north.
  EXPECT_NEAR(convergence_deg, 0.77, 0.01);
  const double offset_deg = report.at("north_offset_deg").get<double>();
  EXPECT_LE(std::abs(offset_deg + convergence_deg), 3.0 * report.at("stddev_deg").get<double>());
  EXPECT_NEAR(
      report.at("found_north_azimuth_deg").get<double>(), offset_deg + convergence_deg, 1e-9);
  EXPECT_EQ(report.at("frames").size(), 6u);
}

TEST(CalibrateNorth, ReportsAMissingMagneticModel) {
  CalibrateNorthOptions options = Courtyard();
  options.model_north = NorthKind::kMagnetic;
  options.magnetic = {"no-such-model", "no-such-folder"};
  EXPECT_THAT([&] { RunCalibrateNorth(options); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("no-such-model")));
}

TEST(DescribeShadowDirection, SaysWhyThereIsNone) {
  ShadowDirection none;
  none.reason = "clouds";
  EXPECT_THAT(DescribeShadowDirection(none), testing::HasSubstr("clouds"));
}

}  // namespace
}  // namespace pleinair::calibrate_north_command_test
