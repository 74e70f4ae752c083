// Albedo and light together, from several frames of a site whose albedos nobody has measured.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"

namespace pleinair {

// What one frame shows of a surface.
struct AlbedoSample {
  DiffuseSample white;       // Its transport is that of a white surface: response / pi.
  std::int32_t surface = 0;  // Of one material, facing one way: has one albedo,
  std::int32_t spot = 0;     // and each spot of it a deviation of its own.
};

struct AlbedoFrame {
  std::vector<AlbedoSample> samples;
  // For samples of the expected albedo: only ratios of lights may be in it, as no unit is known.
  LightingPrior prior;
  bool sun_is_up = true;
  glm::dvec3 clear_beam_rgb{0.0};  // Only its colour is used; black: unknown.
};

struct JointAlbedoOptions {
  // Of an expected albedo, relative. > 0.
  double expected_stddev = 0.4;
  // Errors of a frame's light that all samples of a surface share, relative, beside those of the
  // sky's shape (fit.sky_shape_error). > 0.
  double frame_error = 0.05;
  // Of spots of one surface, relative: stains. > 0.
  double spot_spread = 0.15;
  int max_iterations = 60;  // >= 1.
  LightingFitOptions fit{};
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

struct JointAlbedo {
  std::vector<glm::dvec3> surface_albedo_rgb;
  // Relative, of surfaces against each other: the scale is not in it.
  std::vector<glm::dvec3> surface_stddev_rgb;
  std::vector<glm::dvec3> spot_albedo_rgb;  // Its surface's where nothing is known of it.
  std::vector<LightingFit> lights;          // Per frame.
  bool colour_from_sun = false;
  int iterations = 0;
  bool converged = false;
};

// Albedos and each frame's light that explain all frames, in turn: lights by the robust fit, then
// albedos as the robust mean over frames of what each frame's light says of a surface, weighted by
// how well that light is known there; then each spot's deviation. To twice the albedo belongs half
// the light: one factor for each channel is free, and is fixed so that
// - the mean albedo over the samples, and over RGB, is that of `expected_albedo_rgb`;
// - the strongest suns have the colour of the clear-sky beam; where no frame tells its sun, the
//   mean albedo has the expected one's colour.
//
// `expected_albedo_rgb`  per surface; surfaces and spots are counted from 0.
// Throws std::invalid_argument for no samples, a surface without expected albedo in (0, 1], or a
// spot that belongs to two surfaces.
JointAlbedo FitAlbedoAndLight(std::span<const AlbedoFrame> frames,
                              std::span<const glm::dvec3> expected_albedo_rgb,
                              const JointAlbedoOptions& options = {});

}  // namespace pleinair
