// The bundled courtyard, end to end and against its truth.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/frame_source.h"
#include "datasets/truth.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "pipeline/light_trials.h"
#include "render/gl_context.h"
#include "scene/lighting.h"
#include "session/sequence_site.h"
#include "tests/pipeline/ground_stage.h"
#include "tests/session/bundled_courtyard.h"

namespace pleinair::courtyard_test {
namespace {

const std::filesystem::path kCourtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

// Prepared once for all tests of the file.
class Courtyard : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    sequence_ = ReadSequence(kCourtyard);
    site_ = LoadSequenceSite(*sequence_);
    scene_ = std::make_unique<PreparedScene>(
        PrepareScene(site_->model, PrepareOptionsFor(*site_), *SharedStore(), [](auto, auto) {}));
  }
  static void TearDownTestSuite() {
    gathered_.clear();
    volumes_.clear();
    scene_.reset();
    site_.reset();
    sequence_.reset();
  }

  static std::vector<FrameResult> RunAll(ObjectLight object_light,
                                         std::vector<IrradianceVolume>* volumes = nullptr) {
    FramePipelineOptions options;
    options.object_light.route = object_light;
    return Run(options, sequence_->frames.size(), volumes);
  }

  // All frames by the defaults. Made once for the tests that only read them.
  static const std::vector<FrameResult>& Gathered() {
    if (gathered_.empty()) gathered_ = RunAll(ObjectLight::kGather);
    return gathered_;
  }
  // The probes of all frames by the default route to a volume. Made once, too.
  static const std::vector<IrradianceVolume>& FoldedVolumes() {
    if (volumes_.empty()) RunAll(ObjectLight::kVolume, &volumes_);
    return volumes_;
  }

  static std::vector<FrameResult> Run(const FramePipelineOptions& options,
                                      std::size_t frame_count,
                                      std::vector<IrradianceVolume>* volumes = nullptr) {
    const HeadlessContext context;
    Compositor compositor;
    FramePipeline pipeline({*scene_, site_->model.mesh, sequence_->site, site_->objects},
                           MakeOutdoorLightingSource({}),
                           compositor,
                           options);
    const auto frames = MakeRecordedFrameSource(*sequence_, FrameKind::kLinear);
    std::vector<FrameResult> results;
    for (std::size_t i = 0; i < frame_count; ++i) {
      auto result = pipeline.Process(frames->Next()->value());
      if (!result) {
        ADD_FAILURE() << result.error().reason;
        continue;
      }
      results.push_back(std::move(*result));
      if (volumes != nullptr) volumes->push_back(pipeline.Volume());
    }
    return results;
  }

  static std::optional<Sequence> sequence_;
  static std::optional<SequenceSite> site_;
  static std::unique_ptr<PreparedScene> scene_;
  inline static std::vector<FrameResult> gathered_;
  inline static std::vector<IrradianceVolume> volumes_;
};

std::optional<Sequence> Courtyard::sequence_;
std::optional<SequenceSite> Courtyard::site_;
std::unique_ptr<PreparedScene> Courtyard::scene_;

double QuantileOf(std::vector<double> values, double share) {
  const auto there =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), there, values.end());
  return *there;
}

// Variance of channel `c` of the sum over the sky's shapes.
double SkyVariance(const Lighting& light, std::size_t c) {
  const std::size_t side = 3 * (1 + light.sky.size());
  double variance = 0.0;
  for (std::size_t a = 3 + c; a < side; a += 3) {
    for (std::size_t b = 3 + c; b < side; b += 3) variance += light.covariance[a * side + b];
  }
  return variance;
}

// docs/accuracy.md, "The bundled courtyard": with seeds 1 to 5 of the samples the sun is at most
// 3.0 % of the largest sun off, the sky 2.1 % of itself; medians over the frames are at most 0.7 %
// and 1.1 %. Another choice of samples, or another machine's rounding, moves the worst frames by
// 0.5 % and 1.4 % and the medians by 0.4 % and 0.2 % (standard deviations between seeds), which is
// added once; the site is prepared more coarsely here. What is stated must hold the truth: each
// channel is within twice its deviation (1.1 times at most), and deviations are 3.5 % and 7.4 % at
// most, 0.2 % and 0.5 % of which are noise.
TEST_F(Courtyard, LightFollowsTheClouds) {
  const std::vector<FrameResult>& results = Gathered();
  ASSERT_EQ(results.size(), sequence_->frames.size());
  const std::vector<TruthFrame> truth = ReadTruth(*sequence_);
  ASSERT_EQ(truth.size(), results.size());
  double largest_sun = 0.0;
  for (const TruthFrame& frame : truth) {
    largest_sun = std::max(largest_sun, MeanOf(frame.sun_irradiance_rgb));
  }
  std::vector<double> sun_errors;
  std::vector<double> sky_errors;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Lighting& found = results[i].estimate.lighting;
    const glm::dvec3 found_sky = found.SkyIrradianceRgb();
    sun_errors.push_back(
        std::abs(MeanOf(found.sun.irradiance_rgb) - MeanOf(truth[i].sun_irradiance_rgb)) /
        largest_sun);
    sky_errors.push_back(std::abs(MeanOf(found_sky) / MeanOf(truth[i].sky_irradiance_rgb) - 1.0));
    EXPECT_LT(sun_errors.back(), 0.037) << "frame " << i;
    EXPECT_LT(sky_errors.back(), 0.05) << "frame " << i;
    for (std::size_t c = 0; c < 3; ++c) {
      const int channel = static_cast<int>(c);
      const double sun_stddev = std::sqrt(found.covariance[c * (3 * (1 + found.sky.size()) + 1)]);
      const double sky_stddev = std::sqrt(SkyVariance(found, c));
      EXPECT_LT(sun_stddev, 0.037 * largest_sun) << "frame " << i;
      EXPECT_LT(sky_stddev, 0.08 * found_sky[channel]) << "frame " << i;
      EXPECT_NEAR(
          found.sun.irradiance_rgb[channel], truth[i].sun_irradiance_rgb[channel], 2.0 * sun_stddev)
          << "frame " << i;
      EXPECT_NEAR(found_sky[channel], truth[i].sky_irradiance_rgb[channel], 2.0 * sky_stddev)
          << "frame " << i;
    }
    EXPECT_TRUE(results[i].estimate.sun_observable) << "frame " << i;
  }
  EXPECT_LT(QuantileOf(sun_errors, 0.5), 0.018);
  EXPECT_LT(QuantileOf(sky_errors, 0.5), 0.018);
}

// One view for two sources, of whom the first is the pipeline's.
TEST_F(Courtyard, LightTrialsFindTheLightOfTheWholePipeline) {
  FramePipelineOptions options;
  options.filter.reset();
  const std::vector<FrameResult> whole = Run(options, 2);
  LightTrials trials(*scene_, sequence_->site, options.view);
  std::vector<std::unique_ptr<LightingSource>> sources;
  sources.push_back(MakeOutdoorLightingSource({}));
  sources.push_back(MakeOutdoorLightingSource({.samples = 50, .seed = 2}));
  const auto frames = MakeRecordedFrameSource(*sequence_, FrameKind::kLinear);
  for (const FrameResult& expected : whole) {
    const auto found = trials.Process(frames->Next()->value(), sources);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->size(), 2u);
    EXPECT_EQ((*found)[0]->estimate.lighting.sun.irradiance_rgb,
              expected.estimate.lighting.sun.irradiance_rgb);
    EXPECT_EQ((*found)[0]->estimate.samples_used, 500);
    EXPECT_EQ((*found)[1]->estimate.samples_used, 50);
    EXPECT_GT(trials.ViewMs(), 0.0);
  }
}

TEST_F(Courtyard, BothProbeRoutesGiveTheSameProbes) {
  const std::vector<IrradianceVolume>& folded = FoldedVolumes();
  std::vector<IrradianceVolume> by_map;
  RunAll(ObjectLight::kVolumeByMap, &by_map);
  ASSERT_EQ(folded.size(), by_map.size());
  for (std::size_t i = 0; i < folded.size(); ++i) {
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t probe = 0; probe < folded[i].probes.size(); ++probe) {
      if (folded[i].valid[probe] == 0) continue;  // No object needs it, or it is in a wall.
      for (std::size_t c = 0; c < folded[i].probes[probe].size(); ++c) {
        const glm::dvec3 a(folded[i].probes[probe][c]);
        const glm::dvec3 b(by_map[i].probes[probe][c]);
        difference = std::max(difference, glm::length(a - b));
        size = std::max(size, glm::length(a));
      }
    }
    EXPECT_GT(size, 0.0);
    EXPECT_LE(difference, 1e-4 * size) << "frame " << i;
  }
}

FramePipelineOptions BySamples(ObjectLight object_light, int samples) {
  FramePipelineOptions options;
  options.object_light.route = object_light;
  options.object_light.daylight = Daylight::kSamples;
  options.object_light.direct_daylight.sampling.samples = samples;
  return options;
}

// Without the sky's own light, which is sampled.
TEST_F(Courtyard, BothProbeRoutesLeaveSampledDaylightOut) {
  std::vector<IrradianceVolume> folded;
  std::vector<IrradianceVolume> by_map;
  Run(BySamples(ObjectLight::kVolume, 1), 1, &folded);
  Run(BySamples(ObjectLight::kVolumeByMap, 1), 1, &by_map);
  const IrradianceVolume& with_sky = FoldedVolumes().at(0);
  for (std::size_t probe = 0; probe < with_sky.probes.size(); ++probe) {
    if (folded[0].valid[probe] == 0) continue;  // No object needs it, or it is in a wall.
    const glm::dvec3 whole(with_sky.probes[probe][0]);
    const glm::dvec3 rest(folded[0].probes[probe][0]);
    EXPECT_LE(rest.z, 0.8 * whole.z) << "half of what a probe sees is sky";
    EXPECT_LE(glm::length(rest - glm::dvec3(by_map[0].probes[probe][0])),
              1e-4 * glm::length(whole));
  }
}

// 95 % of the pixels that the object changes, relative. The difference falls with the samples of
// each shape: 3.2 % for one, 1.5 % for 32, 0.45 % for 128 and 0.41 % for 256, where the noise of
// the gathered picture's own 256 rays a vertex and 192 a pixel is left. Its tolerance is that of
// 128 samples and a third of it.
TEST_F(Courtyard, SamplesOfTheSkyGiveTheGatheredPicture) {
  const FrameResult& gathered = Gathered().at(0);
  const FrameResult sampled = std::move(Run(BySamples(ObjectLight::kGather, 128), 1).at(0));
  std::vector<double> differences;
  for (std::size_t i = 0; i < gathered.composite.change.pixels.size(); ++i) {
    if (gathered.composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kNone)) {
      continue;
    }
    differences.push_back(std::abs(
        double{sampled.composite.radiance.pixels[i].y / gathered.composite.radiance.pixels[i].y} -
        1.0));
  }
  EXPECT_LT(QuantileOf(differences, 0.95), 0.006);
  EXPECT_FALSE(gathered.daylight.has_value());
  ASSERT_TRUE(sampled.daylight.has_value());
  EXPECT_EQ(sampled.daylight->samples, 3u * 128u);
  EXPECT_EQ(sampled.daylight->sky_share, 1.0) << "a courtyard has no windows";
}

// What is kept while the camera moves is what would be made again: light, samples, maps, and on
// faces what objects change. The sky stands still, so no map is drawn.
TEST_F(Courtyard, AMovedCameraSeesWhatAFreshPipelineSees) {
  FramePipelineOptions options = BySamples(ObjectLight::kGather, 16);
  options.influence_at = InfluenceAt::kFaces;
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  // What remembers frames by design.
  options.filter.reset();
  options.camera_matching.blur = false;
  const Frame first = MakeRecordedFrameSource(*sequence_, FrameKind::kLinear)->Next()->value();
  Frame second = first;
  second.camera.camera_from_world[3] += glm::dvec4(0.1, 0.05, 0.0, 0.0);
  const auto process = [&](const std::vector<const Frame*>& frames) {
    const HeadlessContext context;
    Compositor compositor;
    FramePipeline pipeline({*scene_, site_->model.mesh, sequence_->site, site_->objects},
                           std::make_unique<StillLight>(),
                           compositor,
                           options);
    std::vector<FrameResult> results;
    results.reserve(frames.size());
    for (const Frame* frame : frames) results.push_back(pipeline.Process(*frame).value());
    return results;
  };
  const std::vector<FrameResult> moved = process({&first, &second, &second});
  const FrameResult fresh = std::move(process({&second}).front());
  EXPECT_GT(moved[0].daylight->maps_drawn, 0u);
  EXPECT_EQ(moved[1].daylight->maps_drawn, 0u);
  EXPECT_EQ(moved[2].daylight->maps_drawn, 0u);
  EXPECT_NE(moved[0].composite.radiance.pixels, moved[1].composite.radiance.pixels);
  EXPECT_EQ(moved[1].composite.radiance.pixels, fresh.composite.radiance.pixels);
  EXPECT_EQ(moved[2].composite.radiance.pixels, fresh.composite.radiance.pixels);
}

TEST_F(Courtyard, ASecondRunGivesTheSameBits) {
  const std::vector<FrameResult>& once = Gathered();
  const std::vector<FrameResult> again = RunAll(ObjectLight::kGather);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].estimate.lighting.sun.irradiance_rgb,
              again[i].estimate.lighting.sun.irradiance_rgb);
    EXPECT_EQ(once[i].composite.radiance.pixels, again[i].composite.radiance.pixels);
  }
}

TEST_F(Courtyard, PixelsThatNothingChangesAreTheCamerasOwn) {
  const std::vector<FrameResult>& results = Gathered();
  const auto frames = MakeRecordedFrameSource(*sequence_, FrameKind::kLinear);
  for (const FrameResult& result : results) {
    const Frame frame = frames->Next()->value();
    std::size_t changed = 0;
    for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
      if (result.composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kNone)) {
        ++changed;
        continue;
      }
      ASSERT_EQ(result.composite.radiance.pixels[i], frame.radiance.pixels[i]) << "pixel " << i;
    }
    EXPECT_GT(changed, 1000u) << "the statue is in the picture";
    EXPECT_LT(changed, frame.radiance.pixels.size() / 2);
  }
}

}  // namespace
}  // namespace pleinair::courtyard_test
