// The sun's disc as points to cast towards, each paired with a place in a pixel.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "objects/object_view.h"
#include "relight/transport/sun_disc.h"
#include "scene/lighting.h"

namespace pleinair {

// Each point of the disc is paired with a place in the pixel's square, so that few rays sample
// both.
class DiscPoints {
 public:
  // Samples of a pixel of an object view.
  static constexpr int kSamplesPerPixel = ObjectView::kSamplesPerSide * ObjectView::kSamplesPerSide;
  struct Point {
    glm::vec3 direction{0.0f};  // Unit.
    glm::dvec2 place{0.0};      // From the pixel's centre, -0.5..0.5.
  };

  // `count` points, also divided equally among a pixel's samples, rounded up.
  // Throws std::invalid_argument for a direction without length and a radius outside [0, pi/2).
  DiscPoints(const DirectionalLight& sun, int count);

  const glm::vec3& Centre() const { return disc_.Direction(); }
  // Four points of the rim, one for each of a pixel's samples.
  const std::array<glm::vec3, 4>& Rim() const { return disc_.Rim(); }
  // Over the entire pixel.
  std::span<const Point> OfPixel() const { return of_pixel_; }
  // Over the part of the pixel that sample `corner` stands for, row by row.
  std::span<const Point> OfSample(int corner) const {
    return of_sample_[static_cast<std::size_t>(corner)];
  }
  // Coordinates across the beam, the first of them level, and towards the sun.
  glm::vec3 InBeam(const glm::vec3& position_m) const;
  float TangentRadius() const { return tangent_radius_; }

 private:
  SunDisc disc_;
  glm::vec3 level_{0.0f};
  glm::vec3 upright_{0.0f};
  float tangent_radius_ = 0.0f;
  std::vector<Point> of_pixel_;
  std::array<std::vector<Point>, kSamplesPerPixel> of_sample_;
};

}  // namespace pleinair
