// Sun and sky from medians: what samples should show, near enough to know their noise by.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"

namespace pleinair {

// The sky's shapes count as one, in equal parts.
struct RoughLight {
  glm::dvec3 sun_rgb{0.0};
  glm::dvec3 sky_rgb{0.0};
  // Of a sample's transport (green): those with a larger share of the sun are sunlit. 1: none is.
  double sunlit_from_share = 1.0;
};

// The sky from the samples with little sun, the sun from those with much, by medians; each channel
// by itself. Where the samples' shares of the sun are alike the two are the same. 0 without
// samples.
RoughLight FindRoughLight(std::span<const DiffuseSample> samples);

// Of the sun in the sample's transport, where it has any.
double SunShare(const DiffuseSample& sample, int channel);

// Over the sky's shapes that the sample has a response to.
double MeanSkyTransport(const DiffuseSample& sample, int channel);

}  // namespace pleinair
