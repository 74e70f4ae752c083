// Recordings whose sun is turned: the shadows in them say by how much.

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/frame_source.h"
#include "pipeline/shadow_direction.h"
#include "pipeline/sun_state.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair::shadow_direction_recorded_test {
namespace {

// Four sunlit frames over the day, and one under cloud where there is one.
void ExpectTurnFound(const std::string& name, const std::set<int>& frames, double turn_deg) {
  const std::filesystem::path folder = std::string(PLEINAIR_SHARED_DIR "/sequences/") + name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << name << " is not here";
  Sequence sequence = ReadSequence(folder);
  std::vector<FrameEntry> few;
  for (const int frame : frames) few.push_back(sequence.frames.at(static_cast<std::size_t>(frame)));
  sequence.frames = few;
  ShadowDirectionFinder finder(LoadMesh(folder / sequence.scene_mesh).mesh,
                               sequence.diffuse_regions);
  const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  while (const auto frame = source->Next()) {
    ASSERT_TRUE(frame->has_value()) << frame->error().reason;
    finder.Add(
        **frame,
        TurnedClockwise(SunOfFrame(sequence.site, **frame).direction_enu, RadFromDeg(turn_deg)));
  }
  const ShadowDirection shadow = finder.Result().all;
  EXPECT_TRUE(shadow.determined) << shadow.reason;
  const double error_deg = DegFromRad(shadow.azimuth_offset_rad) + turn_deg;
  EXPECT_NEAR(error_deg, 0.0, 0.5);
  EXPECT_LE(std::abs(error_deg), 3.0 * DegFromRad(shadow.stddev_rad));
  EXPECT_TRUE(shadow.ContradictsTheSun());
}

TEST(ShadowDirectionOfRecordings, FindsTheTurnInTheCourtyard) {
  ExpectTurnFound("courtyard-clouds", {0, 14, 18, 20, 23}, 5.0);
}

TEST(ShadowDirectionOfRecordings, FindsTheTurnAtTheParking) {
  ExpectTurnFound("parking-shadow", {3, 4, 5, 6, 7}, -5.0);
}

}  // namespace
}  // namespace pleinair::shadow_direction_recorded_test
