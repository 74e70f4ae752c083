// Albedo and light together, from several frames of a site whose albedos have not been measured.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"

namespace pleinair {

// One sample of a surface in one frame.
struct AlbedoSample {
  DiffuseSample white;       // With the transport of a white surface: response / pi.
  std::int32_t surface = 0;  // Index: one material, one facing, one albedo.
  std::int32_t spot = 0;     // Index: a spot deviates from its surface.
};

// One frame's samples, and what is known of its light.
struct AlbedoFrame {
  std::vector<AlbedoSample> samples;
  // For samples of the expected albedo. It may contain only ratios of lights, as no unit is known.
  LightingPrior prior;
  bool sun_is_up = true;
  glm::dvec3 clear_beam_rgb{0.0};  // Only the colour is used; black: unknown.
};

// Assumed errors and limits of the fit.
struct JointAlbedoOptions {
  // Standard deviation of an expected albedo, relative. > 0.
  double expected_stddev = 0.4;
  // Errors of a frame's light that all samples of a surface share, relative. They are in addition
  // to those of the sky's shape (fit.sky_shape_error). > 0.
  double frame_error = 0.05;
  // Spread of the spots' albedos within one surface, relative: stains. > 0.
  double spot_spread = 0.15;
  int max_iterations = 60;  // >= 1.
  LightingFitOptions fit{};
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// The result; albedos in [0, 1], RGB.
struct JointAlbedo {
  std::vector<glm::dvec3> surface_albedo_rgb;
  // Relative, between surfaces: the common scale is not in it.
  std::vector<glm::dvec3> surface_stddev_rgb;
  std::vector<glm::dvec3> spot_albedo_rgb;  // The surface's where the spot was not seen.
  std::vector<LightingFit> lights;          // Per frame.
  bool colour_from_sun = false;
  int iterations = 0;
  bool converged = false;
};

// Finds the albedos and the light of each frame that explain all frames together. It alternates two
// steps. The lights are found by the robust fit. Each surface's albedo is the robust mean over
// frames of its value under each frame's light. The weights are how well that light is known there.
// The deviations of the spots follow. A camera's response that the frames' priors leave open is
// found first, from all frames, and held.
//
// Twice the albedo with half the light explains the same pictures, so one factor for each channel
// is free. It is fixed so that
// - the mean albedo over the samples, and over RGB, is that of `expected_albedo_rgb`;
// - the strongest suns have the colour of the clear-sky beam; where no frame determines its sun,
//   the mean albedo has the expected one's colour.
//
// `expected_albedo_rgb`  per surface; surfaces and spots are counted from 0.
// Throws std::invalid_argument for no samples, a surface without expected albedo in (0, 1], or a
// spot that belongs to two surfaces.
JointAlbedo FitAlbedoAndLight(std::span<const AlbedoFrame> frames,
                              std::span<const glm::dvec3> expected_albedo_rgb,
                              const JointAlbedoOptions& options = {});

}  // namespace pleinair
