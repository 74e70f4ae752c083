// Three photographs of one facade, half a minute apart: the light is the same in all.

#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_view.h"
#include "pipeline/sun_state.h"
#include "relight/surface_view_builder.h"
#include "session/sequence_site.h"

namespace pleinair::photo_light_recorded_test {
namespace {

// Each frame by itself, without the common error of the albedos, which moves all three equally.
std::vector<LightingEstimate> EstimateEachFrame(const Sequence& sequence) {
  const SequenceSite site = LoadSequenceSite(sequence);
  PrepareOptions options = PrepareOptionsFor(site);
  options.patches.patch_size_m = 2.0;
  options.gather.rays_per_receiver = 64;
  options.probe_counts = {2, 2, 2};
  options.probes.rays_per_probe = 16;
  KeepsNothing store;
  const PreparedScene scene = PrepareScene(site.model, options, store, {});
  EXPECT_GT(scene.albedo_stddev_rgb.x, 0.2) << "a guess is not a measurement";

  SurfaceViewBuilder builder(scene, {.receiver_block_px = 16, .sun_block_px = 4});
  const ScaledClearSky clear_sky(sequence.site, nullptr);
  const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLdr);
  std::vector<LightingEstimate> estimates;
  while (auto next = frames->Next()) {
    const Frame& frame = next->value();
    const SunState sun = SunOfFrame(sequence.site, frame);
    const auto source = MakeOutdoorLightingSource({});
    const auto basis = source->BasisFor(frame, sun).value();
    const SurfaceView& view = builder.Update(
        frame.camera, sun.direction_enu, sun.angular_radius_rad, basis, SampleRegionsOf(frame));
    estimates.push_back(
        source->Estimate({frame, view, sun, clear_sky.At(sun.direction_enu)}).value());
  }
  return estimates;
}

// Variances of the sun's channels, and of the sky's sums over its shapes.
std::vector<double> Variances(const Lighting& lighting) {
  const std::size_t side = 3 * (1 + lighting.sky.size());
  std::vector<double> variances(6, 0.0);
  for (std::size_t c = 0; c < 3; ++c) {
    variances[c] = lighting.covariance[c * (side + 1)];
    for (std::size_t a = 3 + c; a < side; a += 3) {
      for (std::size_t b = 3 + c; b < side; b += 3) {
        variances[3 + c] += lighting.covariance[a * side + b];
      }
    }
  }
  return variances;
}

TEST(RecordedPhotographs, LightsOfOneMomentAgreeWithinTheirDeviations) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/berlin-photos";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const std::vector<LightingEstimate> estimates = EstimateEachFrame(ReadSequence(folder));
  ASSERT_EQ(estimates.size(), 3u);
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    // Single stones are 30 % off their material's albedo, blackened ones more.
    EXPECT_GT(estimates[i].relative_residual, 0.1);
    EXPECT_LT(estimates[i].relative_residual, 0.6);
    for (std::size_t j = 0; j < i; ++j) {
      const Lighting& a = estimates[i].lighting;
      const Lighting& b = estimates[j].lighting;
      const std::vector<double> of_a = Variances(a);
      const std::vector<double> of_b = Variances(b);
      for (int u = 0; u < 6; ++u) {
        const double apart = u < 3 ? a.sun.irradiance_rgb[u] - b.sun.irradiance_rgb[u]
                                   : a.SkyIrradianceRgb()[u - 3] - b.SkyIrradianceRgb()[u - 3];
        const auto k = static_cast<std::size_t>(u);
        const double z = apart / std::sqrt(of_a[k] + of_b[k]);
        EXPECT_LT(std::abs(z), 2.0) << "frames " << i << " and " << j << ", unknown " << u;
        squares += z * z;
        ++count;
      }
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 1.0);
}

}  // namespace
}  // namespace pleinair::photo_light_recorded_test
