#include "relight/transport/sun_disc.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

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
  exact_centre_ = direction_enu / length;
  centre_ = glm::vec3(exact_centre_);
  const NormalFrame frame{centre_};
  across_ = std::tan(angular_radius_rad) * glm::dvec3(frame.tangent);
  upwards_ = std::tan(angular_radius_rad) * glm::dvec3(frame.bitangent);
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    rim_[i] = DirectionTo(1.0, 0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5));
  }
  if (samples == 1) {
    samples_.push_back(centre_);
    return;
  }
  // Vogel's sunflower: equal areas, no two samples on one straight edge.
  for (int i = 0; i < samples; ++i) {
    samples_.push_back(DirectionTo(std::sqrt((i + 0.5) / samples),
                                   2.0 * std::numbers::pi * i * (std::numbers::phi - 1.0)));
  }
}

glm::vec3 SunDisc::DirectionTo(double radius, double angle_rad) const {
  return glm::vec3(glm::normalize(
      exact_centre_ + radius * (std::cos(angle_rad) * across_ + std::sin(angle_rad) * upwards_)));
}

float SunDisc::Visibility(const RayCaster& caster, const Receiver& receiver) const {
  const glm::vec3 origin_m = OffsetFromSurface(receiver.position_m, receiver.normal);
  const auto sees = [&](const glm::vec3& direction) {
    return direction.z > 0.0f && glm::dot(direction, receiver.normal) > 0.0f &&
           !caster.Occluded(origin_m, direction);
  };
  const bool centre_seen = sees(centre_);
  const bool agree =
      samples_.size() == 1 || std::all_of(rim_.begin(), rim_.end(), [&](const glm::vec3& rim) {
        return sees(rim) == centre_seen;
      });
  return agree ? (centre_seen ? 1.0f : 0.0f) : ShareOfSamples(caster, receiver);
}

std::vector<float> SunDisc::Visibility(const RayCaster& caster,
                                       std::span<const Receiver> receivers) const {
  std::vector<glm::vec3> origins_m;
  std::vector<glm::vec3> directions;
  std::vector<std::size_t> asked;
  const auto occluded = std::make_unique<bool[]>(receivers.size());
  // Which of `of` see a direction.
  const auto see = [&](const glm::vec3& direction, std::span<const std::size_t> of) {
    origins_m.clear();
    asked.clear();
    for (const std::size_t i : of) {
      const Receiver& receiver = receivers[i];
      if (!(direction.z > 0.0f) || !(glm::dot(direction, receiver.normal) > 0.0f)) continue;
      origins_m.push_back(OffsetFromSurface(receiver.position_m, receiver.normal));
      asked.push_back(i);
    }
    directions.assign(origins_m.size(), direction);
    caster.Occluded(origins_m.data(), directions.data(), origins_m.size(), occluded.get());
    std::vector<bool> sees(receivers.size(), false);
    for (std::size_t k = 0; k < asked.size(); ++k) sees[asked[k]] = !occluded[k];
    return sees;
  };
  std::vector<std::size_t> agreeing(receivers.size());
  std::iota(agreeing.begin(), agreeing.end(), std::size_t{0});
  const std::vector<bool> centre_seen = see(centre_, agreeing);
  std::vector<float> visibility(receivers.size());
  for (std::size_t i = 0; i < receivers.size(); ++i) visibility[i] = centre_seen[i] ? 1.0f : 0.0f;
  if (samples_.size() == 1) return visibility;
  std::vector<std::size_t> partly;
  for (const glm::vec3& rim : rim_) {
    const std::vector<bool> seen = see(rim, agreeing);
    std::erase_if(agreeing, [&](std::size_t i) {
      if (seen[i] == centre_seen[i]) return false;
      partly.push_back(i);
      return true;
    });
  }
  for (const std::size_t i : partly) visibility[i] = ShareOfSamples(caster, receivers[i]);
  return visibility;
}

float SunDisc::ShareOfSamples(const RayCaster& caster, const Receiver& receiver) const {
  const glm::vec3 origin_m = OffsetFromSurface(receiver.position_m, receiver.normal);
  int seen = 0;
  for (const glm::vec3& direction : samples_) {
    seen += direction.z > 0.0f && glm::dot(direction, receiver.normal) > 0.0f &&
                    !caster.Occluded(origin_m, direction)
                ? 1
                : 0;
  }
  return static_cast<float>(seen) / static_cast<float>(samples_.size());
}

float SunDisc::MeanIrradiance(const RayCaster& caster, std::span<const Receiver> points) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::vec3& direction = samples_[i % samples_.size()];
    const auto& [position_m, normal] = points[i];
    const float cosine = glm::dot(direction, normal);
    if (!(cosine > 0.0f) || !(direction.z > 0.0f)) continue;
    if (!caster.Occluded(OffsetFromSurface(position_m, normal), direction)) sum += cosine;
  }
  return points.empty() ? 0.0f : static_cast<float>(sum / static_cast<double>(points.size()));
}

}  // namespace pleinair
