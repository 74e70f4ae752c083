// The one mapping between directions and lat-long (equirectangular) images.
//
// Top row zenith, centre column north, azimuth clockwise (east is right of the centre). Image
// coordinates (u, v) are in pixels from the image's top left corner: pixel (x, y) has its centre at
// (x + 0.5, y + 0.5).
//   azimuth = (u / width - 0.5) * 2 pi, elevation = (0.5 - v / height) * pi
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Size of a lat-long image in pixels.
struct LatLongSize {
  int width = 0;
  int height = 0;
};

// Unit direction, ENU, through image point `uv_px`.
glm::dvec3 DirectionFromLatLong(glm::dvec2 uv_px, LatLongSize size);

// Image point of a direction of any non-zero length; u in [0, width), v in [0, height]. At the
// poles u is width / 2. Throws std::invalid_argument for a zero or non-finite direction.
glm::dvec2 LatLongFromDirection(const glm::dvec3& direction_enu, LatLongSize size);

// The pixel that contains that point.
glm::ivec2 LatLongPixelFromDirection(const glm::dvec3& direction_enu, LatLongSize size);

// Solid angle in steradians of a pixel of row `y`, exact for the mapping.
double LatLongPixelSolidAngleSr(int y, LatLongSize size);

// Bilinear look-up that wraps around the seam and over the poles.
glm::vec3 SampleLatLong(const RgbImage& image, const glm::dvec3& direction_enu);

// Returns `image` turned about the vertical: content at azimuth A moves to A + clockwise_rad.
// Linear between pixels' centres, so that each row keeps its light.
RgbImage TurnedLatLong(const RgbImage& image, double clockwise_rad);

// Solid-angle-weighted reduction to `size` (each side must divide the image's).
RgbImage DownsampleLatLong(const RgbImage& image, LatLongSize size);

}  // namespace pleinair
