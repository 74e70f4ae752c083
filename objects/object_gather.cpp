#include "objects/object_gather.h"

#include "objects/internal/face_count.h"

namespace pleinair {
namespace {

void AppendTriangles(const Mesh& mesh, Mesh& joined) {
  const auto first_vertex = static_cast<std::uint32_t>(joined.positions_m.size());
  joined.positions_m.insert(
      joined.positions_m.end(), mesh.positions_m.begin(), mesh.positions_m.end());
  for (const glm::uvec3& triangle : mesh.triangles) {
    joined.triangles.push_back(triangle + first_vertex);
  }
}

}  // namespace

// Each in the middle of the third of a triangle that is nearest to the vertex; the vertex itself
// where it is in none. They gather over the vertex's own hemisphere.
std::vector<Receiver> ObjectGather::PointsAround(const Mesh& mesh) {
  const std::size_t vertices = mesh.positions_m.size();
  std::vector<std::vector<glm::vec3>> around(vertices);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3& own = mesh.positions_m[triangle[corner]];
      const glm::vec3& next = mesh.positions_m[triangle[(corner + 1) % 3]];
      const glm::vec3& last = mesh.positions_m[triangle[(corner + 2) % 3]];
      // The centroid of corner, middles of its two edges and of the triangle.
      around[triangle[corner]].push_back((22.0f * own + 7.0f * next + 7.0f * last) / 36.0f);
    }
  }
  std::vector<Receiver> points;
  points.reserve(vertices * kPointsPerVertex);
  for (std::size_t v = 0; v < vertices; ++v) {
    if (around[v].empty()) around[v].push_back(mesh.positions_m[v]);
    for (std::size_t i = 0; i < kPointsPerVertex; ++i) {
      points.push_back({around[v][i * around[v].size() / kPointsPerVertex], mesh.normals[v]});
    }
  }
  return points;
}

ObjectGather::ObjectGather(const PatchScene& objects,
                           const PatchScene& real,
                           const GatherOptions& options)
    : object_faces_(objects.FaceCount()), real_faces_(real.FaceCount()) {
  PatchScene joined;
  AppendTriangles(objects.mesh, joined.mesh);
  // The objects' triangles are the first ones: what cuts them out stays theirs.
  joined.mesh.materials = objects.mesh.materials;
  joined.mesh.triangle_material = objects.mesh.triangle_material;
  joined.mesh.triangle_colours = objects.mesh.triangle_colours;
  AppendTriangles(real.mesh, joined.mesh);
  if (!real.several.Empty()) {
    // Patches of the objects are triangles.
    const auto before = static_cast<std::uint32_t>(objects.mesh.triangles.size());
    PatchesOfTriangles& several = joined.several;
    for (std::uint32_t triangle = 0; triangle < before; ++triangle) {
      several.begin.push_back(triangle);
      several.of_triangle.push_back(triangle);
    }
    for (const std::uint32_t begin : real.several.begin) several.begin.push_back(before + begin);
    for (const std::uint32_t patch : real.several.of_triangle) {
      several.of_triangle.push_back(before + patch);
    }
  }
  joined.caster = RayCaster(joined.mesh);
  const std::vector<Receiver> points = PointsAround(objects.mesh);
  GatherOptions of_point = options;
  constexpr int kPoints = static_cast<int>(kPointsPerVertex);
  of_point.rays_per_receiver = (options.rays_per_receiver + kPoints - 1) / kPoints;
  of_point.receivers_per_set = kPoints;
  rays_ = GatheredRays(joined, points, of_point);

  // A point within a part meets its walls from behind.
  std::vector<glm::vec3> is_back(object_faces_ + real_faces_, glm::vec3(0.0f));
  for (std::size_t face = 1; face < object_faces_; face += 2) is_back[face] = glm::vec3(1.0f);
  constexpr float kMostFromBehind = 0.5f;
  weights_.resize(points.size());
  for (std::size_t first = 0; first < points.size(); first += kPointsPerVertex) {
    float open = 0.0f;
    for (std::size_t i = first; i < first + kPointsPerVertex; ++i) {
      weights_[i] = rays_.FromFacesAt(i, is_back).x > kMostFromBehind ? 0.0f : 1.0f;
      open += weights_[i];
    }
    for (std::size_t i = first; i < first + kPointsPerVertex; ++i) {
      weights_[i] = open > 0.0f ? weights_[i] / open : 1.0f / static_cast<float>(kPointsPerVertex);
    }
  }
  FindBuried(objects.mesh);
}

void ObjectGather::FindBuried(const Mesh& objects) {
  std::vector<glm::vec3> is_back(object_faces_ + real_faces_, glm::vec3(0.0f));
  for (std::size_t face = 1; face < object_faces_; face += 2) is_back[face] = glm::vec3(1.0f);
  // In a closed part all rays are stopped; from within an open one, a bowl, some get out.
  constexpr float kAllFromBehind = 0.99f;
  std::vector<bool> is_buried(VertexCount());
  for (std::size_t v = 0; v < VertexCount(); ++v) {
    is_buried[v] = true;
    for (std::size_t i = v * kPointsPerVertex; i < (v + 1) * kPointsPerVertex; ++i) {
      is_buried[v] = is_buried[v] && rays_.FromFacesAt(i, is_back).x > kAllFromBehind;
    }
  }
  std::vector<std::vector<std::uint32_t>> neighbours(VertexCount());
  for (const glm::uvec3& triangle : objects.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      for (int step = 1; step < 3; ++step) {
        const std::uint32_t other = triangle[(corner + step) % 3];
        if (is_buried[triangle[corner]] && !is_buried[other]) {
          neighbours[triangle[corner]].push_back(other);
        }
      }
    }
  }
  for (std::size_t v = 0; v < VertexCount(); ++v) {
    if (neighbours[v].empty()) continue;
    buried_.push_back({static_cast<std::uint32_t>(v), std::move(neighbours[v])});
  }
}

std::vector<glm::vec3> ObjectGather::AtVertices(std::span<const glm::vec3> at_points) const {
  std::vector<glm::vec3> at_vertices(VertexCount(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < at_points.size(); ++i) {
    at_vertices[i / kPointsPerVertex] += weights_[i] * at_points[i];
  }
  for (const Buried& buried : buried_) {
    glm::vec3 sum(0.0f);
    for (const std::uint32_t neighbour : buried.neighbours) sum += at_vertices[neighbour];
    at_vertices[buried.vertex] = sum / static_cast<float>(buried.neighbours.size());
  }
  return at_vertices;
}

std::vector<glm::vec3> ObjectGather::Irradiance(const SkyShape* sky,
                                                std::span<const glm::vec3> object_radiosity,
                                                std::span<const glm::vec3> real_radiosity) const {
  RequireFaceCount("object_radiosity", object_radiosity.size(), object_faces_);
  RequireFaceCount("real_radiosity", real_radiosity.size(), real_faces_);
  std::vector<glm::vec3> radiosity(object_radiosity.begin(), object_radiosity.end());
  radiosity.insert(radiosity.end(), real_radiosity.begin(), real_radiosity.end());
  std::vector<glm::vec3> at_points = rays_.FromFaces(radiosity);
  if (sky != nullptr) {
    const std::vector<glm::vec3> from_sky = rays_.FromSky(*sky);
    for (std::size_t i = 0; i < at_points.size(); ++i) at_points[i] += from_sky[i];
  }
  return AtVertices(at_points);
}

}  // namespace pleinair
