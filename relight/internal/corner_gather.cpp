#include "relight/internal/corner_gather.h"

#include <cmath>
#include <map>
#include <tuple>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// How far a corner's receiver is drawn towards the middle of each of its faces, so that one on the
// rim of a wall does not stand in the wall beside it.
constexpr float kInset = 0.15f;
// Faces whose normals agree to so much are of one plane.
constexpr float kNormalSteps = 512.0f;

// Position, and the normal in steps.
using CornerKey = std::tuple<float, float, float, int, int, int>;

CornerKey KeyOf(const glm::vec3& position_m, const glm::vec3& normal) {
  const auto step = [](float value) { return static_cast<int>(std::lround(value * kNormalSteps)); };
  return {position_m.x, position_m.y, position_m.z, step(normal.x), step(normal.y), step(normal.z)};
}

}  // namespace

CornerGather::CornerGather(const PatchScene& scene, const GatherOptions& options) {
  struct Corner {
    std::uint32_t receiver;
    glm::dvec3 sum_m{0.0};
    int faces = 0;
  };
  std::map<CornerKey, Corner> corners;
  std::vector<Receiver> receivers;
  receivers_.resize(scene.FaceCount());
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    const glm::uvec3& vertices = scene.mesh.triangles[face / 2];
    const glm::vec3 normal = scene.FaceNormal(face);
    const glm::vec3 middle_m =
        (scene.mesh.positions_m[vertices.x] + scene.mesh.positions_m[vertices.y] +
         scene.mesh.positions_m[vertices.z]) /
        3.0f;
    for (int i = 0; i < 3; ++i) {
      const glm::vec3& position_m = scene.mesh.positions_m[vertices[i]];
      const auto next = static_cast<std::uint32_t>(receivers.size());
      Corner& corner = corners.try_emplace(KeyOf(position_m, normal), Corner{next}).first->second;
      if (corner.receiver == next) receivers.push_back({position_m, normal});
      corner.sum_m += glm::dvec3(position_m + kInset * (middle_m - position_m));
      ++corner.faces;
      receivers_[face][static_cast<std::size_t>(i)] = corner.receiver;
    }
  }
  for (const auto& [key, corner] : corners) {
    receivers[corner.receiver].position_m =
        glm::vec3(corner.sum_m / static_cast<double>(corner.faces));
  }
  rays_ = std::make_shared<const GatheredRays>(scene, receivers, options);
}

}  // namespace pleinair
