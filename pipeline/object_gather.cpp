#include "pipeline/object_gather.h"

#include <stdexcept>
#include <string>

namespace pleinair {
namespace {

void Append(const Mesh& mesh, Mesh& joined) {
  const auto first_vertex = static_cast<std::uint32_t>(joined.positions_m.size());
  joined.positions_m.insert(
      joined.positions_m.end(), mesh.positions_m.begin(), mesh.positions_m.end());
  for (const glm::uvec3& triangle : mesh.triangles) {
    joined.triangles.push_back(triangle + first_vertex);
  }
}

void CheckFaceCount(const char* what, std::size_t count, std::size_t expected) {
  if (count == expected) return;
  throw std::invalid_argument(std::string(what) + " has " + std::to_string(count) +
                              " entries: expected one a face, " + std::to_string(expected));
}

}  // namespace

ObjectGather::ObjectGather(const PatchScene& objects,
                           const PatchScene& real,
                           const GatherOptions& options)
    : object_faces_(objects.FaceCount()), real_faces_(real.FaceCount()) {
  PatchScene joined;
  Append(objects.mesh, joined.mesh);
  Append(real.mesh, joined.mesh);
  joined.caster = RayCaster(joined.mesh);
  std::vector<Receiver> vertices;
  vertices.reserve(objects.mesh.positions_m.size());
  for (std::size_t v = 0; v < objects.mesh.positions_m.size(); ++v) {
    vertices.push_back({objects.mesh.positions_m[v], objects.mesh.normals[v]});
  }
  rays_ = GatheredRays(joined, vertices, options);
}

std::vector<glm::vec3> ObjectGather::Irradiance(const SkyShape* sky,
                                                std::span<const glm::vec3> object_radiosity,
                                                std::span<const glm::vec3> real_radiosity) const {
  CheckFaceCount("object_radiosity", object_radiosity.size(), object_faces_);
  CheckFaceCount("real_radiosity", real_radiosity.size(), real_faces_);
  std::vector<glm::vec3> radiosity(object_radiosity.begin(), object_radiosity.end());
  radiosity.insert(radiosity.end(), real_radiosity.begin(), real_radiosity.end());
  std::vector<glm::vec3> irradiance = rays_.FromFaces(radiosity);
  if (sky == nullptr) return irradiance;
  const std::vector<glm::vec3> from_sky = rays_.FromSky(*sky);
  for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += from_sky[v];
  return irradiance;
}

}  // namespace pleinair
