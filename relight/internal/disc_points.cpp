#include "relight/internal/disc_points.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "relight/internal/low_discrepancy.h"

namespace pleinair {

DiscPoints::DiscPoints(const DirectionalLight& sun, int count) {
  static_assert(kSamplesPerPixel == 4);  // As many as rim points.
  const double length = glm::length(sun.direction_enu);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("soft sun: the sun's direction has length " +
                                std::to_string(length) + ", expected a unit vector");
  }
  if (!(sun.angular_radius_rad >= 0.0) || !(sun.angular_radius_rad < 0.5 * std::numbers::pi)) {
    throw std::invalid_argument("soft sun: angular_radius_rad is " +
                                std::to_string(sun.angular_radius_rad) + ": expected [0, pi/2)");
  }
  const glm::dvec3 centre = sun.direction_enu / length;
  const NormalFrame frame{glm::vec3(centre)};
  const double tangent_radius = std::tan(sun.angular_radius_rad);
  const auto direction = [&](double radius, double angle) {
    return glm::vec3(glm::normalize(centre + radius * tangent_radius *
                                                 (std::cos(angle) * glm::dvec3(frame.tangent) +
                                                  std::sin(angle) * glm::dvec3(frame.bitangent))));
  };
  centre_ = glm::vec3(centre);
  // What stands upright is narrow across the level axis; with the sun in the zenith any will do.
  const glm::dvec3 level(centre.y, -centre.x, 0.0);
  level_ = glm::length(level) > 1e-6 ? glm::vec3(glm::normalize(level)) : frame.tangent;
  upright_ = glm::cross(centre_, level_);
  tangent_radius_ = static_cast<float>(tangent_radius);
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    rim_[i] = direction(1.0, 0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5));
  }
  // Vogel's sunflower: equal areas, no two points on one straight edge. Of the places that go with
  // them the same holds.
  for (int i = 0; i < count; ++i) {
    of_pixel_.push_back({direction(std::sqrt((i + 0.5) / count),
                                   2.0 * std::numbers::pi * i * (std::numbers::phi - 1.0)),
                         R2Point(i, glm::dvec2(0.5)) - 0.5});
  }
  // A sunflower for each of a pixel's samples, turned and set off against the others'.
  constexpr int kSide = ObjectView::kSamplesPerSide;
  const int per_sample = (count + kSamplesPerPixel - 1) / kSamplesPerPixel;
  for (int corner = 0; corner < kSamplesPerPixel; ++corner) {
    const glm::dvec2 lower(corner % kSide, corner / kSide);
    for (int i = 0; i < per_sample; ++i) {
      const double rank = i + (corner + 0.5) / kSamplesPerPixel;
      const double turns = (i + 0.4 * corner) * (std::numbers::phi - 1.0);
      const glm::dvec2 place = R2Point(i, glm::dvec2(0.5));
      of_sample_[static_cast<std::size_t>(corner)].push_back(
          {direction(std::sqrt(rank / per_sample), 2.0 * std::numbers::pi * turns),
           (lower + place) / double{kSide} - 0.5});
    }
  }
}

glm::vec3 DiscPoints::InBeam(const glm::vec3& position_m) const {
  return {
      glm::dot(position_m, level_), glm::dot(position_m, upright_), glm::dot(position_m, centre_)};
}

}  // namespace pleinair
