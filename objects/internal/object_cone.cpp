#include "objects/internal/object_cone.h"

#include <cstdint>
#include <numbers>

namespace pleinair {

std::vector<std::optional<ObjectBounds>> BoundsOfObjects(const Mesh& mesh) {
  std::vector<std::optional<ObjectBounds>> bounds(mesh.group_names.size());
  const auto for_corners = [&mesh](const auto& visit) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int corner = 0; corner < 3; ++corner) {
        visit(mesh.triangle_group[t], mesh.positions_m[mesh.triangles[t][corner]]);
      }
    }
  };
  for_corners([&](std::uint32_t group, const glm::vec3& position_m) {
    if (!bounds[group]) bounds[group] = ObjectBounds{{}, 0.0f, {position_m, position_m}};
    bounds[group]->box.lower_m = glm::min(bounds[group]->box.lower_m, position_m);
    bounds[group]->box.upper_m = glm::max(bounds[group]->box.upper_m, position_m);
  });
  for (std::optional<ObjectBounds>& object : bounds) {
    if (object) object->centre_m = 0.5f * (object->box.lower_m + object->box.upper_m);
  }
  for_corners([&](std::uint32_t group, const glm::vec3& position_m) {
    bounds[group]->radius_m =
        std::max(bounds[group]->radius_m, glm::distance(position_m, bounds[group]->centre_m));
  });
  return bounds;
}

ObjectCone::ObjectCone(const ObjectBounds& object, const glm::vec3& from_m) {
  const glm::vec3 apart = object.centre_m - from_m;
  const float distance_m = glm::length(apart);
  if (!(distance_m > object.radius_m)) return;
  const float sine = object.radius_m / distance_m;
  axis = apart / distance_m;
  one_minus_cos = sine * sine / (1.0f + std::sqrt(1.0f - sine * sine));
}

float ObjectCone::LargestShare(const glm::vec3& normal) const {
  const float cos_half = 1.0f - one_minus_cos;
  const float cos_axis = glm::clamp(glm::dot(normal, axis), -1.0f, 1.0f);
  // Largest cosine in the cone: of the angle to the axis less the half angle.
  float largest = 1.0f;
  if (cos_half > 0.0f && cos_axis < cos_half) {
    const float sin_half = std::sqrt(1.0f - cos_half * cos_half);
    const float sin_axis = std::sqrt(1.0f - cos_axis * cos_axis);
    largest = cos_axis * cos_half + sin_axis * sin_half;
  }
  return std::min(1.0f, 2.0f * one_minus_cos * std::max(largest, 0.0f));
}

namespace {

// Order of a place in the square of side 2 around 0, by its cell of 64 x 64: places near in this
// order are near each other.
std::uint32_t MortonOf(float x, float y) {
  const auto cell = [](float value) {
    return static_cast<std::uint32_t>(std::clamp(32.0f * (value + 1.0f), 0.0f, 63.0f));
  };
  std::uint32_t code = 0;
  for (std::uint32_t bit = 0; bit < 6; ++bit) {
    code |= (cell(x) >> bit & 1u) << (2 * bit) | (cell(y) >> bit & 1u) << (2 * bit + 1);
  }
  return code;
}

}  // namespace

ConeDirections::ConeDirections(int count) {
  for (int k = 0; k < count; ++k) {
    const glm::dvec2 point = FibonacciPoint(k, count, {0.0, 0.0});
    const double angle = 2.0 * std::numbers::pi * point.y;
    const double radius = std::sqrt(point.x);
    points_.push_back({static_cast<float>(point.x),
                       static_cast<float>(radius * std::cos(angle)),
                       static_cast<float>(radius * std::sin(angle)),
                       static_cast<float>(std::sqrt(1.0 - point.x))});
  }
  // Neighbours are cast together.
  std::stable_sort(points_.begin(), points_.end(), [](const Point& a, const Point& b) {
    return MortonOf(a.x, a.y) < MortonOf(b.x, b.y);
  });
}

}  // namespace pleinair
