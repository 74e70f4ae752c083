// A made yard with two houses, and photographs of it under any sun.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "scene/frame.h"
#include "scene/ray_caster.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "tests/scene/box_mesh.h"

namespace pleinair::yard {

inline constexpr int kWidth = 160;
inline constexpr int kHeight = 120;
inline constexpr double kLit = 1.0;
inline constexpr double kShaded = 0.25;
inline const std::vector<std::string> kGround = {"ground"};

inline void Append(Mesh& mesh, const Mesh& part, const std::string& group) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  mesh.positions_m.insert(mesh.positions_m.end(), part.positions_m.begin(), part.positions_m.end());
  mesh.normals.insert(mesh.normals.end(), part.normals.begin(), part.normals.end());
  for (const glm::uvec3& triangle : part.triangles) mesh.triangles.push_back(triangle + first);
  mesh.materials.resize(1);
  mesh.triangle_material.resize(mesh.triangles.size(), 0);
  mesh.triangle_group.resize(mesh.triangles.size(),
                             static_cast<std::uint32_t>(mesh.group_names.size()));
  mesh.group_names.push_back(group);
}

inline Mesh Ground() {
  Mesh mesh;
  Append(mesh, BoxMesh({-40.0f, -40.0f, -0.5f}, {40.0f, 40.0f, 0.0f}), "ground");
  return mesh;
}

inline Mesh Yard(float height_m) {
  Mesh mesh = Ground();
  Append(mesh, BoxMesh({-7.0f, 3.0f, 0.0f}, {-3.0f, 6.0f, height_m}), "west");
  Append(mesh, BoxMesh({2.0f, 4.0f, 0.0f}, {4.0f, 7.0f, 1.3f * height_m}), "east");
  return mesh;
}

// 14 m up, 16 m south, looking down at the yard.
inline Camera YardCamera() {
  Camera camera;
  camera.intrinsics = {kWidth, kHeight, 130.0, 130.0, 79.5, 59.5, {}};
  const glm::dvec3 centre_m{0.0, -16.0, 14.0};
  const glm::dvec3 forward = glm::normalize(glm::dvec3(0.0, 4.0, 0.0) - centre_m);
  const glm::dvec3 right{1.0, 0.0, 0.0};
  const glm::dvec3 down = glm::cross(forward, right);
  const glm::dmat3 rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.camera_from_world = glm::dmat4(rotation);
  camera.camera_from_world[3] = glm::dvec4(-(rotation * centre_m), 1.0);
  return camera;
}

inline glm::dvec3 Sun(double azimuth_deg, double elevation_deg) {
  const double elevation = RadFromDeg(elevation_deg);
  return TurnedClockwise({0.0, std::cos(elevation), std::sin(elevation)}, RadFromDeg(azimuth_deg));
}

// What a surface point sends out, given whether it has sun.
using Shading = std::function<double(const glm::vec3& position_m, bool lit)>;

inline double TwoLevels(const glm::vec3&, bool lit) { return lit ? kLit : kShaded; }

// Colour of shade under a blue sky, as bright as white.
inline const glm::vec3 kOfShade{0.95f, 1.0f, 1.147f};

// 15 % of texture and noise, seeded by the frame's number. `of_shade`: colour of what has no sun.
inline Frame Photograph(const Mesh& mesh,
                        const glm::dvec3& sun,
                        int index,
                        const Shading& shading,
                        const glm::vec3& of_shade = kOfShade) {
  const RayCaster caster(mesh);
  Frame frame;
  frame.index = index;
  frame.camera = YardCamera();
  frame.radiance = RgbImage(kWidth, kHeight, glm::vec3(0.0f));
  frame.unusable = Gray8Image(kWidth, kHeight, 0);
  frame.clipped = Gray8Image(kWidth, kHeight, 0);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(frame.camera.camera_from_world));
  std::mt19937 random(static_cast<std::uint32_t>(index));
  std::normal_distribution<double> texture(0.0, 0.15);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::vec3 ray(
          glm::normalize(world_from_camera * *DirectionFromPixel(frame.camera.intrinsics, {x, y})));
      const auto hit = caster.Intersect(glm::vec3(frame.camera.CentreWorldM()), ray);
      const double factor = std::exp(texture(random));
      if (!hit) continue;
      const glm::vec3 to_sun(sun);
      const bool lit =
          glm::dot(hit->geometric_normal, to_sun) > 0.0f &&
          !caster.Occluded(OffsetFromSurface(hit->position_m, hit->geometric_normal), to_sun);
      frame.radiance.At(x, y) =
          float(factor * shading(hit->position_m, lit)) * (lit ? glm::vec3(1.0f) : of_shade);
    }
  }
  return frame;
}

}  // namespace pleinair::yard
