// Courtyards without their survey map: albedos found from their frames, against the survey's.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "pipeline/self_calibration.h"
#include "relight/surface_view_builder.h"
#include "session/sequence_session.h"
#include "session/sequence_site.h"
#include "session/session_choices.h"

namespace pleinair::self_calibration_test {
namespace {

PreparedScene Prepare(const SequenceSite& site) {
  PrepareOptions options = PrepareOptionsFor(site);
  options.patches.patch_size_m = 1.5;
  options.patches.growth_per_m = 0.2;
  options.gather.rays_per_receiver = 64;
  options.survey_receiver_block_px = 8;
  options.probe_counts = {2, 2, 2};
  options.probes.rays_per_probe = 16;
  KeepsNothing store;
  return PrepareScene(site.model, options, store, {});
}

// Medians over the camera's pixels of each group's albedo in the scene, per channel.
std::map<std::string, glm::dvec3> GroupAlbedos(const PreparedScene& scene, const Camera& camera) {
  SurfaceViewBuilder builder(scene, {.receiver_block_px = 32, .sun_block_px = 8});
  const std::vector<std::shared_ptr<const SkyShape>> shapes{MakeUniformSkyShape()};
  const SurfaceView& view = builder.Update(camera, {0.0, 0.0, 1.0}, 0.005, shapes, {});
  std::map<std::string, std::array<std::vector<double>, 3>> values;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.may_be_sampled.pixels[i] == 0 || view.edge_distance_px.pixels[i] < 3.0f) continue;
    auto& of = values[view.region_names[static_cast<std::size_t>(view.region.pixels[i])]];
    for (std::size_t c = 0; c < 3; ++c) {
      of[c].push_back(view.albedo_rgb.pixels[i][static_cast<int>(c)]);
    }
  }
  std::map<std::string, glm::dvec3> medians;
  for (auto& [group, of] : values) {
    if (of[0].size() < 500) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      std::nth_element(
          of[c].begin(), of[c].begin() + std::ptrdiff_t(of[c].size() / 2), of[c].end());
      medians[group][static_cast<int>(c)] = of[c][of[c].size() / 2];
    }
  }
  return medians;
}

SelfCalibrationOptions Coarsely() {
  SelfCalibrationOptions options;
  options.frames = 8;
  options.samples = 500;
  options.rounds = 2;
  options.receiver_block_px = 8;
  options.mean_albedo = 0.3;
  return options;
}

class BundledCourtyard : public testing::Test {
 protected:
  Sequence sequence_ = ReadSequence(PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard");

  std::unique_ptr<FrameSource> Frames() const {
    return MakeRecordedFrameSource(sequence_, FrameKind::kLinear);
  }
};

// A few frames, a third of each determined only by the prior: finite numbers, of the size that was
// asked for.
TEST_F(BundledCourtyard, GetsAlbedosOfTheStatedMean) {
  sequence_.environment.reset();
  PreparedScene scene = Prepare(LoadSequenceSite(sequence_));
  const SelfCalibration found =
      SelfCalibrateAlbedo([&] { return Frames(); }, sequence_.site, Coarsely(), scene);
  EXPECT_EQ(found.frames, static_cast<int>(sequence_.frames.size()));
  EXPECT_GT(found.surfaces, 1);
  EXPECT_GT(found.surface_stddev, 0.0);
  EXPECT_LT(found.surface_stddev, Coarsely().joint.expected_stddev);
  for (const glm::vec3& albedo : scene.patches.face_albedo_rgb) {
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(albedo[c] > 0.0f && albedo[c] <= 0.98f) << albedo[c];
  }
  glm::dvec3 mean(0.0);
  const auto groups = GroupAlbedos(scene, sequence_.CameraOfFrame(0));
  for (const auto& [group, albedo] : groups) mean += albedo / double(groups.size());
  // Groups count equally here, samples there.
  EXPECT_NEAR((mean.x + mean.y + mean.z) / 3.0, 0.3, 0.1);
  EXPECT_THAT(scene.notes.back(), testing::HasSubstr("their mean is taken to be 0.30"));
}

TEST_F(BundledCourtyard, RefusesASurveyAndImpossibleOptions) {
  PreparedScene surveyed;
  surveyed.survey.emplace();
  const auto calibrate = [&](const SelfCalibrationOptions& options, PreparedScene& scene) {
    SelfCalibrateAlbedo([&] { return Frames(); }, sequence_.site, options, scene);
  };
  EXPECT_THROW(calibrate(Coarsely(), surveyed), std::invalid_argument);
  PreparedScene scene;
  const auto refused = [&](const auto& spoil) {
    SelfCalibrationOptions options = Coarsely();
    spoil(options);
    EXPECT_THROW(calibrate(options, scene), std::invalid_argument);
  };
  refused([](auto& options) { options.frames = 0; });
  refused([](auto& options) { options.rounds = 0; });
  refused([](auto& options) { options.samples = 0; });
  refused([](auto& options) { options.mean_albedo = 1.5; });
  refused([](auto& options) { options.sky_shapes.clear(); });
}

TEST_F(BundledCourtyard, IsCalibratedByItselfOnlyWhereNothingSaysBetter) {
  const SessionOptions options;
  EXPECT_EQ(AlbedoSourceOf(options, sequence_), AlbedoSource::kSurvey);
  sequence_.environment.reset();
  EXPECT_EQ(AlbedoSourceOf(options, sequence_), AlbedoSource::kSelfCalibrated);
  SessionOptions given;
  given.lighting = "lighting.jsonl";
  EXPECT_EQ(AlbedoSourceOf(given, sequence_), AlbedoSource::kMaterials);
  sequence_.albedos_assumed = true;
  EXPECT_EQ(AlbedoSourceOf(options, sequence_), AlbedoSource::kMaterials);
  SessionOptions asked;
  asked.albedo = AlbedoSource::kSelfCalibrated;
  EXPECT_EQ(AlbedoSourceOf(asked, sequence_), AlbedoSource::kSelfCalibrated);
}

TEST(RecordedSelfCalibration, AgreesWithTheSurveyUpToOneScale) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  Sequence sequence = ReadSequence(folder);
  const Camera camera = sequence.CameraOfFrame(0);
  const auto surveyed = GroupAlbedos(Prepare(LoadSequenceSite(sequence)), camera);

  sequence.environment.reset();
  PreparedScene scene = Prepare(LoadSequenceSite(sequence));
  const SelfCalibrationOptions options = Coarsely();
  const SelfCalibration found =
      SelfCalibrateAlbedo([&] { return MakeRecordedFrameSource(sequence, FrameKind::kLinear); },
                          sequence.site,
                          options,
                          scene);
  EXPECT_EQ(found.frames, 8);
  EXPECT_TRUE(found.converged);
  EXPECT_TRUE(found.colour_from_sun);
  EXPECT_EQ(scene.albedo_stddev_rgb, glm::dvec3(options.joint.expected_stddev));
  const auto calibrated = GroupAlbedos(scene, camera);

  std::vector<double> log_ratios;
  for (const auto& [group, albedo] : calibrated) {
    const auto survey = surveyed.find(group);
    if (survey == surveyed.end()) continue;
    for (int c = 0; c < 3; ++c) log_ratios.push_back(std::log(albedo[c] / survey->second[c]));
  }
  ASSERT_GE(log_ratios.size(), 6u);
  double mean = 0.0;
  for (const double ratio : log_ratios) mean += ratio / double(log_ratios.size());
  EXPECT_LT(std::abs(mean), 2.0 * options.joint.expected_stddev) << "the scale";
  for (const double ratio : log_ratios) {
    // 2.5 times what is stated of each, and the survey's own 1 %.
    EXPECT_LT(std::abs(ratio - mean), 0.08);
    EXPECT_LT(std::abs(ratio - mean), 3.0 * found.surface_stddev);
  }
}

}  // namespace
}  // namespace pleinair::self_calibration_test
