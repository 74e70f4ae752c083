#include "relight/daylight_shadows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/internal/low_discrepancy.h"

namespace pleinair {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

}  // namespace

void DaylightShadowOptions::Validate() const {
  if (map_size_px < 0 || map_size_px > 1024) {
    throw std::invalid_argument("map_size_px is " + std::to_string(map_size_px) +
                                ": expected 0 to 1024");
  }
}

DaylightShadows::DaylightShadows(const RayCaster& real,
                                 const RayCaster& objects,
                                 const BoundingSphere& sphere,
                                 const DaylightShadowOptions& options)
    : real_(real),
      objects_(objects),
      centre_m_(sphere.centre_m),
      // Rounding of the sphere and of the maps' axes must not cut off the objects' outermost
      // points.
      radius_m_(static_cast<float>(1.0001 * sphere.radius_m)),
      map_size_px_(options.map_size_px) {
  options.Validate();
  if (!(sphere.radius_m > 0.0) || !std::isfinite(radius_m_)) {
    throw std::invalid_argument(std::string("daylight shadows: bounding sphere of radius ") +
                                std::to_string(sphere.radius_m) + " m: expected more than 0");
  }
}

void DaylightShadows::SetSamples(std::span<const DaylightSample> samples) {
  std::vector<std::size_t> stale;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i >= views_.size() || views_[i].sample.direction_enu != samples[i].direction_enu) {
      stale.push_back(i);
    }
  }
  views_.resize(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) views_[i].sample = samples[i];
  for (const std::size_t i : stale) {
    const NormalFrame frame(samples[i].direction_enu);
    views_[i].right = frame.tangent;
    views_[i].up = frame.bitangent;
  }
  maps_drawn_ = map_size_px_ > 0 ? stale.size() : 0;
  if (map_size_px_ == 0) return;
  const auto cells =
      static_cast<std::size_t>(map_size_px_) * static_cast<std::size_t>(map_size_px_);
  reach_m_.resize(samples.size() * cells);
  tbb::parallel_for(std::size_t{0}, stale.size(), [&](std::size_t i) { DrawMap(stale[i]); });
}

void DaylightShadows::DrawMap(std::size_t index) {
  const View& view = views_[index];
  const glm::vec3& direction = view.sample.direction_enu;
  const glm::vec3 front_m = centre_m_ + radius_m_ * direction;
  float* reach = reach_m_.data() + index * static_cast<std::size_t>(map_size_px_) *
                                       static_cast<std::size_t>(map_size_px_);
  const float cell_m = 2.0f * radius_m_ / static_cast<float>(map_size_px_);
  for (int row = 0; row < map_size_px_; ++row) {
    for (int column = 0; column < map_size_px_; ++column) {
      const float x_m = (static_cast<float>(column) + 0.5f) * cell_m - radius_m_;
      const float y_m = (static_cast<float>(row) + 0.5f) * cell_m - radius_m_;
      *reach = kNothing;
      if (x_m * x_m + y_m * y_m < radius_m_ * radius_m_) {
        const auto hit = objects_.Intersect(front_m + x_m * view.right + y_m * view.up, -direction);
        if (hit) *reach = radius_m_ - hit->distance_m;
      }
      ++reach;
    }
  }
}

bool DaylightShadows::InObjectsShadow(std::size_t index, const glm::vec3& position_m) const {
  const View& view = views_[index];
  const glm::vec3 from_centre_m = position_m - centre_m_;
  const float x_m = glm::dot(from_centre_m, view.right);
  const float y_m = glm::dot(from_centre_m, view.up);
  const float along_m = glm::dot(from_centre_m, view.sample.direction_enu);
  if (x_m * x_m + y_m * y_m >= radius_m_ * radius_m_ || along_m >= radius_m_) return false;
  if (map_size_px_ == 0) return objects_.Occluded(position_m, view.sample.direction_enu);
  const float per_m = 0.5f * static_cast<float>(map_size_px_) / radius_m_;
  const auto cell = [&](float at_m) {
    return std::min(static_cast<int>((at_m + radius_m_) * per_m), map_size_px_ - 1);
  };
  const std::size_t row =
      index * static_cast<std::size_t>(map_size_px_) + static_cast<std::size_t>(cell(y_m));
  return reach_m_[row * static_cast<std::size_t>(map_size_px_) +
                  static_cast<std::size_t>(cell(x_m))] > along_m;
}

std::vector<glm::vec3> DaylightShadows::OnObjects(std::span<const Receiver> receivers) const {
  std::vector<glm::vec3> irradiance(receivers.size(), glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, receivers.size(), [&](std::size_t i) {
    const glm::vec3 start_m = OffsetFromSurface(receivers[i].position_m, receivers[i].normal);
    for (const View& view : views_) {
      const glm::vec3& direction = view.sample.direction_enu;
      const float cosine = glm::dot(receivers[i].normal, direction);
      if (!(cosine > 0.0f) || objects_.Occluded(start_m, direction) ||
          real_.Occluded(start_m, direction)) {
        continue;
      }
      irradiance[i] += cosine * view.sample.irradiance_rgb;
    }
  });
  return irradiance;
}

std::vector<glm::vec3> DaylightShadows::HiddenFrom(std::span<const Receiver> receivers) const {
  std::vector<glm::vec3> hidden(receivers.size(), glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, receivers.size(), [&](std::size_t i) {
    const glm::vec3 start_m = OffsetFromSurface(receivers[i].position_m, receivers[i].normal);
    for (std::size_t k = 0; k < views_.size(); ++k) {
      const DaylightSample& sample = views_[k].sample;
      const float cosine = glm::dot(receivers[i].normal, sample.direction_enu);
      if (!(cosine > 0.0f) || !InObjectsShadow(k, start_m) ||
          real_.Occluded(start_m, sample.direction_enu)) {
        continue;
      }
      hidden[i] += cosine * sample.irradiance_rgb;
    }
  });
  return hidden;
}

}  // namespace pleinair
