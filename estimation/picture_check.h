// Whether the surfaces in a frame's picture have the light that another camera measured.
#pragma once

#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "scene/lighting.h"

namespace pleinair {

// Medians over samples of what the picture has over what the light gives.
struct PictureOverLight {
  glm::dvec3 ratio_rgb{1.0};
  glm::dvec3 shaded_ratio_rgb{1.0};  // Of the samples that the sun does not reach; of all if few.
  // Of green: the median factor between a sample's ratio and ratio_rgb; 1 where all agree.
  double scatter = 1.0;
  // Of green: the ratio of the samples in the sun over that of the others. 1 where either are few.
  // Well above 1, the sun that lights the picture is not in the light; well below, it is but does
  // not reach the picture.
  double lit_over_others = 1.0;
};

// None where hardly any sample can be compared. Shapes as in `lighting`, whose sky must not have
// more than kMaxSkyShapes.
std::optional<PictureOverLight> CompareWithPicture(std::span<const DiffuseSample> samples,
                                                   const Lighting& lighting);

}  // namespace pleinair
