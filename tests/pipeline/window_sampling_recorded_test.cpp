// Daylight samples under the recorded room's own skies: its fish-eye pictures, window and object.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "datasets/fisheye_setup.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/fisheye_sky.h"
#include "objects/daylight_shadows.h"
#include "pipeline/sun_state.h"
#include "relight/daylight/window_sampling.h"
#include "scene/mesh_io.h"
#include "tests/relight/seed_spread.h"

namespace pleinair::window_sampling_recorded_test {
namespace {

const std::filesystem::path kRoom =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";

// The bar, for 64 samples, in every other frame: a quarter of the variance or less, and the mean of
// 200 draws within 1 % of one of 65536 samples from the entire sky.
TEST(WindowSamplingRecorded, HasAQuarterOfTheVarianceUnderTheRecordedSkies) {
  if (!std::filesystem::exists(kRoom)) GTEST_SKIP() << kRoom << " is not there";
  const Sequence sequence = ReadSequence(kRoom);
  const RayCaster room(LoadMesh(kRoom / sequence.scene_mesh).mesh);
  const Mesh object = TransformMesh(sequence.virtual_objects[0].world_from_object,
                                    LoadMesh(kRoom / sequence.virtual_objects[0].mesh).mesh);
  const RayCaster objects(object);
  const BoundingSphere sphere = BoundingSphereOf(object.positions_m);
  const std::vector<Window> windows{
      {sequence.windows[0].name, sequence.windows[0].polygon_world_m}};
  std::vector<Receiver> receivers;
  for (std::size_t v = 0; v < object.positions_m.size(); v += 120) {
    receivers.push_back({object.positions_m[v], object.normals[v]});
  }
  DaylightShadows light(room, objects, sphere, {.map_size_px = 0});
  FisheyeSky fisheye(MakeFisheyeSetup(*sequence.fisheye, kRoom).camera, SkyRegions());
  const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  int count = 0;
  while (const auto next = frames->Next()) {
    const Frame& frame = next->value();
    if (frame.index % 2 != 0) continue;
    const SunState sun = SunOfFrame(sequence.site, frame);
    fisheye.Read(frame.fisheye_radiance.value(), sun.direction_enu, sun.angular_radius_rad);
    Lighting lighting;
    lighting.sky = {{"image", fisheye.SkyIrradianceRgb()}};
    const std::vector<glm::vec3> sky =
        SkyRadianceTable(lighting, std::vector<std::shared_ptr<const SkyShape>>{fisheye.Shape()});
    const auto spread = [&](DaylightRestriction restriction, int samples, int seeds) {
      return SpreadOverSeeds({windows, sphere, sky},
                             {.samples = samples, .restriction = restriction},
                             seeds,
                             [&](const DaylightSamples& drawn) {
                               light.SetSamples(drawn.samples);
                               std::vector<double> values;
                               for (const glm::vec3& rgb : light.OnObjects(receivers)) {
                                 values.push_back(static_cast<double>(rgb.x + rgb.y + rgb.z));
                               }
                               return values;
                             });
    };
    const SeedSpread window = spread(DaylightRestriction::kWindows, 64, 200);
    const SeedSpread whole = spread(DaylightRestriction::kWholeSky, 64, 20);
    const double reference = spread(DaylightRestriction::kWholeSky, 65536, 1).mean;
    EXPECT_GE(whole.variance, 4.0 * window.variance) << frame.index;
    EXPECT_NEAR(window.mean, reference, 0.01 * reference) << frame.index;
    RecordProperty(std::string("frame_") + std::to_string(frame.index),
                   std::to_string(whole.variance / window.variance) + " times, mean off by " +
                       std::to_string(window.mean / reference - 1.0));
    ++count;
  }
  EXPECT_EQ(count, 4);
}

}  // namespace
}  // namespace pleinair::window_sampling_recorded_test
