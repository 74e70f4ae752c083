// Sun and sky from medians: accurate enough to predict the noise of samples.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"

namespace pleinair {

// Irradiances; the sky's shapes count as one, in equal parts.
struct RoughLight {
  glm::dvec3 sun_rgb{0.0};
  glm::dvec3 sky_rgb{0.0};
  // Samples with a larger share of the sun in their transport (green) are sunlit. 1: none is.
  double sunlit_from_share = 1.0;
};

// Finds by medians the sky from the samples with little sun and the sun from those with much, for
// each channel separately. Where the samples have similar shares of the sun, the two are equal. 0
// without samples.
RoughLight FindRoughLight(std::span<const DiffuseSample> samples);

// Share of the sun in the sample's transport, where it has any.
double SunShare(const DiffuseSample& sample, int channel);

// Mean over the sky's shapes that the sample has a response to.
double MeanSkyTransport(const DiffuseSample& sample, int channel);

}  // namespace pleinair
