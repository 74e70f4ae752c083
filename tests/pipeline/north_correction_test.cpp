// A yard whose model is turned from true north, photographed over a day.
#include "pipeline/north_correction.h"

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/sun_state.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"
#include "tests/pipeline/yard_pictures.h"

namespace pleinair::north_correction_test {
namespace {

using testing::HasSubstr;
using yard::kGround;

const Site kAalborg{0.99569, 0.17317, 15.0};

class FramesInMemory final : public FrameSource {
 public:
  explicit FramesInMemory(std::vector<Frame> frames) : frames_(std::move(frames)) {}
  std::optional<tl::expected<Frame, FrameError>> Next() override {
    if (next_ == frames_.size()) return std::nullopt;
    return frames_[next_++];
  }
  std::optional<int> Count() const override { return static_cast<int>(frames_.size()); }

 private:
  std::vector<Frame> frames_;
  std::size_t next_ = 0;
};

// The model's +Y points to true azimuth `north_deg`.
std::vector<Frame> DayInTheYard(double north_deg, const yard::Shading& shading) {
  Site site = kAalborg;
  site.model_north_azimuth_rad = RadFromDeg(north_deg);
  std::vector<Frame> frames;
  for (const char* time : {"2005-06-21T07:50:00Z", "2005-06-21T13:30:00Z"}) {
    const SunState sun = SunOverSite(site, ParseUtcTime(time));
    frames.push_back(yard::Photograph(
        yard::Yard(4.0f), sun.direction_enu, static_cast<int>(frames.size()), shading));
    frames.back().time = ParseUtcTime(time);
  }
  return frames;
}

NorthCorrection CorrectedFor(const std::vector<Frame>& frames, double stated_deg) {
  return CorrectNorth([&] { return std::make_unique<FramesInMemory>(frames); },
                      kAalborg,
                      yard::Yard(4.0f),
                      kGround,
                      RadFromDeg(stated_deg));
}

// Two frames determine north to half a degree; the stated uncertainty must hold the error.
TEST(NorthCorrection, FindsTheNorthOfTheModel) {
  for (const auto& [north_deg, stated_deg] :
       std::vector<std::pair<double, double>>{{1.5, 1.5}, {-4.0, 3.0}, {0.0, 2.0}, {60.0, 45.0}}) {
    SCOPED_TRACE(north_deg);
    const NorthCorrection north =
        CorrectedFor(DayInTheYard(north_deg, yard::TwoLevels), stated_deg);
    ASSERT_TRUE(north.determined) << north.reason;
    EXPECT_EQ(north.frames, 2);
    const double off_rad = north.north_azimuth_rad - RadFromDeg(north_deg);
    EXPECT_LT(std::abs(off_rad), RadFromDeg(0.7));
    EXPECT_LE(std::abs(off_rad), 3.0 * north.stddev_rad);
    EXPECT_LT(north.stddev_rad, RadFromDeg(1.5));
  }
}

// A narrow statement holds the answer back, as a normal prior does.
TEST(NorthCorrection, WeighsShadowsAgainstWhatIsStated) {
  const std::vector<Frame> frames = DayInTheYard(1.0, yard::TwoLevels);
  const NorthCorrection north = CorrectedFor(frames, 0.5);
  ASSERT_TRUE(north.determined) << north.reason;
  const double stated = std::pow(RadFromDeg(0.5), 2);
  const double seen = std::pow(north.shadows_stddev_rad, 2);
  EXPECT_NEAR(north.north_azimuth_rad, north.shadows_azimuth_rad * stated / (stated + seen), 1e-12);
  EXPECT_LT(north.stddev_rad, RadFromDeg(0.5));
}

TEST(NorthCorrection, ChangesNothingWhereShadowsSayNothing) {
  const auto overcast = [](const glm::vec3&, bool) { return 0.3; };
  const NorthCorrection clouds = CorrectedFor(DayInTheYard(2.0, overcast), 2.0);
  EXPECT_FALSE(clouds.determined);
  EXPECT_FALSE(clouds.reason.empty());
  EXPECT_EQ(clouds.north_azimuth_rad, 0.0);
  EXPECT_EQ(clouds.stddev_rad, RadFromDeg(2.0));

  const NorthCorrection far_off = CorrectedFor(DayInTheYard(12.0, yard::TwoLevels), 0.5);
  EXPECT_FALSE(far_off.determined);
  EXPECT_THAT(far_off.reason, HasSubstr("contradict"));
  EXPECT_EQ(far_off.north_azimuth_rad, 0.0);

  std::vector<Frame> stated = DayInTheYard(2.0, yard::TwoLevels);
  for (Frame& frame : stated) frame.sun_direction_enu = yard::Sun(150.0, 40.0);
  const NorthCorrection none = CorrectedFor(stated, 2.0);
  EXPECT_FALSE(none.determined);
  EXPECT_EQ(none.frames, 0);
}

TEST(NorthCorrection, RefusesADeviationThatIsNone) {
  for (const double deg : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(CorrectedFor({}, deg), std::invalid_argument);
  }
}

}  // namespace
}  // namespace pleinair::north_correction_test
