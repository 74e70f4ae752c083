// Where on the screen a picture's pixels are.
#pragma once

#include <glm/vec2.hpp>

namespace pleinair {

// Integer pixel coordinates are pixel centres.
struct PicturePlace {
  glm::dvec2 origin{0.0};  // Place of its upper left corner.
  double scale = 1.0;      // Screen units a pixel.

  glm::dvec2 ToScreen(const glm::dvec2& pixel) const { return origin + scale * (pixel + 0.5); }
  glm::dvec2 ToPixel(const glm::dvec2& screen) const { return (screen - origin) / scale - 0.5; }
};

}  // namespace pleinair
