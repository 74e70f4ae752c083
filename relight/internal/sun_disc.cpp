#include "relight/internal/sun_disc.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "relight/internal/low_discrepancy.h"

namespace pleinair {

SunDisc::SunDisc(const glm::dvec3& direction_enu, double angular_radius_rad, int samples) {
  const double length = glm::length(direction_enu);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("sun_direction_enu has length " + std::to_string(length) +
                                ": expected a unit vector");
  }
  if (!(angular_radius_rad >= 0.0) || !(angular_radius_rad < 0.5 * std::numbers::pi)) {
    throw std::invalid_argument("sun_angular_radius_rad is " + std::to_string(angular_radius_rad) +
                                ": expected [0, pi/2)");
  }
  if (samples < 1) {
    throw std::invalid_argument("sun_disc_samples is " + std::to_string(samples) +
                                ": expected at least 1");
  }
  const glm::dvec3 centre = direction_enu / length;
  const NormalFrame frame{glm::vec3(centre)};
  const double tangent_radius = std::tan(angular_radius_rad);
  const auto direction = [&](double radius, double angle) {
    return glm::vec3(glm::normalize(centre + radius * std::cos(angle) * glm::dvec3(frame.tangent) +
                                    radius * std::sin(angle) * glm::dvec3(frame.bitangent)));
  };
  centre_ = glm::vec3(centre);
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    rim_[i] = direction(tangent_radius, 0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5));
  }
  if (samples == 1) {
    samples_.push_back(centre_);
    return;
  }
  // Vogel's sunflower: equal areas, no two samples on one straight edge.
  for (int i = 0; i < samples; ++i) {
    const double radius = tangent_radius * std::sqrt((i + 0.5) / samples);
    samples_.push_back(direction(radius, 2.0 * std::numbers::pi * i * (std::numbers::phi - 1.0)));
  }
}

float SunDisc::Visibility(const RayCaster& caster, const Receiver& receiver) const {
  const glm::vec3 origin = OffsetFromSurface(receiver.position_m, receiver.normal);
  const auto sees = [&](const glm::vec3& direction) {
    return direction.z > 0.0f && glm::dot(direction, receiver.normal) > 0.0f &&
           !caster.Occluded(origin, direction);
  };
  const bool centre_seen = sees(centre_);
  if (samples_.size() == 1) return centre_seen ? 1.0f : 0.0f;
  bool agree = true;
  for (std::size_t i = 0; i < rim_.size() && agree; ++i) agree = sees(rim_[i]) == centre_seen;
  if (agree) return centre_seen ? 1.0f : 0.0f;
  int seen = 0;
  for (const glm::vec3& direction : samples_) seen += sees(direction);
  return static_cast<float>(seen) / static_cast<float>(samples_.size());
}

float SunDisc::MeanIrradiance(const RayCaster& caster,
                              std::span<const glm::vec3> points,
                              const glm::vec3& normal) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::vec3& direction = samples_[i % samples_.size()];
    const float cosine = glm::dot(direction, normal);
    if (!(cosine > 0.0f) || !(direction.z > 0.0f)) continue;
    if (!caster.Occluded(OffsetFromSurface(points[i], normal), direction)) sum += cosine;
  }
  return points.empty() ? 0.0f : static_cast<float>(sum / static_cast<double>(points.size()));
}

}  // namespace pleinair
