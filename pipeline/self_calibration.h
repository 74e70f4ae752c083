// Albedos of a site without a survey, from the recorded frames themselves.
#pragma once

#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/frame_source.h"
#include "estimation/joint_albedo.h"
#include "relight/prepared_scene.h"
#include "sunmodel/site.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {

// Set-up of the self-calibration.
struct SelfCalibrationOptions {
  int frames = 16;     // At most, spread evenly over the recording. >= 1.
  int samples = 1000;  // A frame. 1 .. 100000.
  std::uint64_t seed = 1;
  // Shapes of the sky with which the light is estimated.
  std::vector<SkyShapeKind> sky_shapes{std::begin(kAllSkyShapeKinds), std::end(kAllSkyShapeKinds)};
  // How often light between surfaces is recomputed with the albedos found. >= 1.
  int rounds = 3;
  // The assumed mean albedo, in (0, 1]; none: the materials' own.
  std::optional<double> mean_albedo;
  int receiver_block_px = 4;  // As in SurfaceViewOptions.
  // expected_stddev is also that of the common scale.
  JointAlbedoOptions joint;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// How it ended, for reports.
struct SelfCalibration {
  int frames = 0;
  int surfaces = 0;
  // Relative deviation of the surfaces' albedos from each other, median over surfaces and RGB.
  double surface_stddev = 0.0;
  bool colour_from_sun = false;
  bool converged = false;
};

// Finds the albedos of the surfaces that the frames show, by FitAlbedoAndLight: surfaces are one
// material of a group with one facing, spots are the scene's patches. Sets
// scene.patches.face_albedo_rgb; faces that no frame shows get the mean of their group, or of their
// material. Sets scene.albedo_stddev_rgb to the deviation of the scale, which no picture
// determines, and adds a note.
//
// `open_frames`  returns the recording from its start, at each call.
// Throws std::invalid_argument for a scene with a survey, std::runtime_error where no frame could
// be used.
SelfCalibration SelfCalibrateAlbedo(
    const std::function<std::unique_ptr<FrameSource>()>& open_frames,
    const std::optional<Site>& site,
    const SelfCalibrationOptions& options,
    PreparedScene& scene);

}  // namespace pleinair
