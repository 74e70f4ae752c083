#include "objects/internal/disc_points.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {

DiscPoints::DiscPoints(const DirectionalLight& sun, int count)
    : disc_(sun.direction_enu, sun.angular_radius_rad, count),
      tangent_radius_(static_cast<float>(std::tan(sun.angular_radius_rad))) {
  static_assert(kSamplesPerPixel == 4);  // As many as rim points.
  const glm::dvec3 centre(disc_.Direction());
  // Upright objects are narrow across the level axis; with the sun in the zenith any axis serves.
  const glm::dvec3 level(centre.y, -centre.x, 0.0);
  level_ =
      glm::length(level) > 1e-6 ? glm::vec3(glm::normalize(level)) : NormalFrame(Centre()).tangent;
  upright_ = glm::cross(Centre(), level_);
  // No two of the disc's samples are on one straight edge, nor are two of the places that belong to
  // them.
  for (int i = 0; i < count; ++i) {
    of_pixel_.push_back(
        {disc_.Samples()[static_cast<std::size_t>(i)], R2Point(i, glm::dvec2(0.5)) - 0.5});
  }
  // One sunflower pattern for each of a pixel's samples, rotated and offset against the others.
  constexpr int kSide = ObjectView::kSamplesPerSide;
  const int per_sample = (count + kSamplesPerPixel - 1) / kSamplesPerPixel;
  for (int corner = 0; corner < kSamplesPerPixel; ++corner) {
    const glm::dvec2 lower(corner % kSide, corner / kSide);
    for (int i = 0; i < per_sample; ++i) {
      const double rank = i + (corner + 0.5) / kSamplesPerPixel;
      const double turns = (i + 0.4 * corner) * (std::numbers::phi - 1.0);
      const glm::dvec2 place = R2Point(i, glm::dvec2(0.5));
      of_sample_[static_cast<std::size_t>(corner)].push_back(
          {disc_.DirectionTo(std::sqrt(rank / per_sample), 2.0 * std::numbers::pi * turns),
           (lower + place) / double{kSide} - 0.5});
    }
  }
}

glm::vec3 DiscPoints::InBeam(const glm::vec3& position_m) const {
  return {
      glm::dot(position_m, level_), glm::dot(position_m, upright_), glm::dot(position_m, Centre())};
}

}  // namespace pleinair
