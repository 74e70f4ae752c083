// The survey's environment map for the current light, pixel by pixel (jensen-2006, section 4.2).
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "scene/image.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

// Radiance of each map pixel for one unit basis light; the sun's disc itself is not in it.
struct EnvironmentBasis {
  RgbImage radiance;
};

// albedo / pi * response on surfaces, the shape itself where the map sees sky.
EnvironmentBasis EnvironmentOfSun(const Survey& survey, const glm::dvec3& sun_direction_enu);
EnvironmentBasis EnvironmentOfSky(const Survey& survey,
                                  std::size_t sky_index,
                                  const SkyShape& shape);

// Writes sum_k intensity_k * basis_k into `environment`, keeping its memory. `basis`: sun first.
void SynthesiseEnvironment(std::span<const EnvironmentBasis> basis,
                           const Lighting& lighting,
                           RgbImage& environment);

}  // namespace pleinair
