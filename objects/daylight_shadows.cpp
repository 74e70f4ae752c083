#include "objects/daylight_shadows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

constexpr float kReachesNothing = -std::numeric_limits<float>::infinity();

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
  const std::vector<glm::vec3> directions(static_cast<std::size_t>(map_size_px_), -direction);
  std::vector<std::optional<RayHit>> hits(directions.size());
  std::vector<glm::vec3> starts_m;
  std::vector<int> columns;
  for (int row = 0; row < map_size_px_; ++row, reach += map_size_px_) {
    const float y_m = (static_cast<float>(row) + 0.5f) * cell_m - radius_m_;
    starts_m.clear();
    columns.clear();
    for (int column = 0; column < map_size_px_; ++column) {
      const float x_m = (static_cast<float>(column) + 0.5f) * cell_m - radius_m_;
      if (!(x_m * x_m + y_m * y_m < radius_m_ * radius_m_)) continue;
      starts_m.push_back(front_m + x_m * view.right + y_m * view.up);
      columns.push_back(column);
    }
    objects_.Intersect(starts_m.data(), directions.data(), starts_m.size(), hits.data());
    std::fill_n(reach, map_size_px_, kReachesNothing);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (hits[i]) reach[columns[i]] = radius_m_ - hits[i]->distance_m;
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
  // Rays of one sample from a stretch of neighbours are parallel: they go together.
  constexpr std::size_t kTogether = 256;
  tbb::parallel_for(
      std::size_t{0}, (receivers.size() + kTogether - 1) / kTogether, [&](auto block) {
        const std::size_t begin = block * kTogether;
        const std::size_t end = std::min(receivers.size(), begin + kTogether);
        std::array<std::size_t, kTogether> lit;
        std::array<glm::vec3, kTogether> starts_m;
        std::array<glm::vec3, kTogether> directions;
        std::array<bool, kTogether> occluded;
        for (const View& view : views_) {
          std::size_t count = 0;
          for (std::size_t i = begin; i < end; ++i) {
            if (!(glm::dot(receivers[i].normal, view.sample.direction_enu) > 0.0f)) continue;
            lit[count] = i;
            starts_m[count] = OffsetFromSurface(receivers[i].position_m, receivers[i].normal);
            ++count;
          }
          directions.fill(view.sample.direction_enu);
          for (const RayCaster* caster : {&objects_, &real_}) {
            caster->Occluded(starts_m.data(), directions.data(), count, occluded.data());
            std::size_t left = 0;
            for (std::size_t k = 0; k < count; ++k) {
              if (occluded[k]) continue;
              lit[left] = lit[k];
              starts_m[left] = starts_m[k];
              ++left;
            }
            count = left;
          }
          for (std::size_t k = 0; k < count; ++k) {
            const float cosine = glm::dot(receivers[lit[k]].normal, view.sample.direction_enu);
            irradiance[lit[k]] += cosine * view.sample.irradiance_rgb;
          }
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
