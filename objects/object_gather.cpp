#include "objects/object_gather.h"

#include <algorithm>
#include <numeric>

#include <tbb/parallel_for.h>

#include "objects/internal/face_count.h"

namespace pleinair {
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

ObjectGather ObjectGather::InParts(const PatchScene& objects,
                                   const PatchScene& real,
                                   const GatherOptions& options) {
  options.Validate();
  ObjectGather gather;
  gather.object_faces_ = objects.FaceCount();
  gather.real_faces_ = real.FaceCount();
  gather.points_ = PointsAround(objects.mesh);
  gather.of_point_ = options;
  constexpr int kPoints = static_cast<int>(kPointsPerVertex);
  gather.of_point_.rays_per_receiver = (options.rays_per_receiver + kPoints - 1) / kPoints;
  gather.of_point_.receivers_per_set = kPoints;
  gather.of_point_.keep_directions_from_face = gather.object_faces_;
  gather.parts_.resize((gather.VertexCount() + kVerticesPerPart - 1) / kVerticesPerPart);
  gather.lacking_ = gather.parts_.size();
  return gather;
}

ObjectGather::ObjectGather(const PatchScene& objects,
                           const PatchScene& real,
                           const GatherOptions& options)
    : ObjectGather(InParts(objects, real, options)) {
  std::vector<std::size_t> all(parts_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Cast(objects, real, all);
}

ObjectGather::Range ObjectGather::VerticesOf(std::size_t part) const {
  return {part * kVerticesPerPart, std::min((part + 1) * kVerticesPerPart, VertexCount())};
}

std::span<const Receiver> ObjectGather::PointsOf(std::size_t part) const {
  const auto [begin, end] = VerticesOf(part);
  return std::span(points_).subspan(begin * kPointsPerVertex, (end - begin) * kPointsPerVertex);
}

void ObjectGather::Cast(const PatchScene& objects,
                        const PatchScene& real,
                        std::span<const std::size_t> parts) {
  std::vector<std::size_t> lacking;
  for (const std::size_t part : parts) {
    if (!HasCast(part)) lacking.push_back(part);
  }
  std::sort(lacking.begin(), lacking.end());
  lacking.erase(std::unique(lacking.begin(), lacking.end()), lacking.end());
  tbb::parallel_for(
      std::size_t{0}, lacking.size(), [&](std::size_t i) { CastPart(objects, real, lacking[i]); });
  lacking_ -= lacking.size();
  if (lacking_ == 0 && !lacking.empty()) FindBuried(objects.mesh);
}

void ObjectGather::CastPart(const PatchScene& objects, const PatchScene& real, std::size_t index) {
  Part& part = parts_[index];
  GatherOptions options = of_point_;
  options.first_receiver = VerticesOf(index).begin * kPointsPerVertex;
  const std::span<const Receiver> points = PointsOf(index);
  part.rays = GatheredRays(objects, real, points, options);
  // A point within a part meets its walls from behind.
  const auto from_behind_at = [&](std::size_t point) {
    float sum = 0.0f;
    for (const auto& [face, share] : part.rays.FacesOf(point)) {
      const auto hit = static_cast<std::size_t>(face);
      if (hit < object_faces_ && hit % 2 == 1) sum += share;
    }
    return sum;
  };
  constexpr float kMostFromBehind = 0.5f;
  // In a closed part all rays are stopped; from within an open one, a bowl, some get out.
  constexpr float kAllFromBehind = 0.99f;
  part.weights.resize(points.size());
  for (std::size_t first = 0; first < points.size(); first += kPointsPerVertex) {
    float open = 0.0f;
    bool is_buried = true;
    for (std::size_t i = first; i < first + kPointsPerVertex; ++i) {
      const float from_behind = from_behind_at(i);
      part.weights[i] = from_behind > kMostFromBehind ? 0.0f : 1.0f;
      open += part.weights[i];
      is_buried = is_buried && from_behind > kAllFromBehind;
    }
    for (std::size_t i = first; i < first + kPointsPerVertex; ++i) {
      part.weights[i] =
          open > 0.0f ? part.weights[i] / open : 1.0f / static_cast<float>(kPointsPerVertex);
    }
    part.is_buried.push_back(is_buried);
  }
}

void ObjectGather::FindBuried(const Mesh& objects) {
  std::vector<std::vector<std::uint32_t>> neighbours(VertexCount());
  for (const glm::uvec3& triangle : objects.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      for (int step = 1; step < 3; ++step) {
        const std::uint32_t other = triangle[(corner + step) % 3];
        if (IsBuried(triangle[corner]) && !IsBuried(other)) {
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

void ObjectGather::Fill(std::span<const Buried> buried, std::span<glm::vec3> at_vertices) {
  for (const auto& [vertex, neighbours] : buried) {
    glm::vec3 sum(0.0f);
    for (const std::uint32_t neighbour : neighbours) sum += at_vertices[neighbour];
    at_vertices[vertex] = sum / static_cast<float>(neighbours.size());
  }
}

std::vector<glm::vec3> ObjectGather::AtVerticesOf(std::size_t part,
                                                  std::span<const glm::vec3> at_points) const {
  const std::vector<float>& weights = parts_[part].weights;
  std::vector<glm::vec3> at_vertices(weights.size() / kPointsPerVertex, glm::vec3(0.0f));
  for (std::size_t i = 0; i < weights.size(); ++i) {
    at_vertices[i / kPointsPerVertex] += weights[i] * at_points[i];
  }
  return at_vertices;
}

std::vector<glm::vec3> ObjectGather::AtVertices(std::span<const glm::vec3> at_points) const {
  std::vector<glm::vec3> at_vertices;
  at_vertices.reserve(VertexCount());
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    const std::size_t points = parts_[part].weights.size();
    const std::vector<glm::vec3> of_part = AtVerticesOf(part, at_points.first(points));
    at_vertices.insert(at_vertices.end(), of_part.begin(), of_part.end());
    at_points = at_points.subspan(points);
  }
  Fill(buried_, at_vertices);
  return at_vertices;
}

std::vector<glm::vec3> ObjectGather::IrradianceOf(std::size_t part,
                                                  const SkyShape* sky,
                                                  std::span<const glm::vec3> radiosity) const {
  const GatheredRays& rays = parts_[part].rays;
  std::vector<glm::vec3> at_points = rays.FromFaces(radiosity);
  if (sky != nullptr) {
    const std::vector<glm::vec3> from_sky = rays.FromSky(*sky);
    for (std::size_t i = 0; i < at_points.size(); ++i) at_points[i] += from_sky[i];
  }
  return AtVerticesOf(part, at_points);
}

std::vector<glm::vec3> ObjectGather::Irradiance(const SkyShape* sky,
                                                std::span<const glm::vec3> object_radiosity,
                                                std::span<const glm::vec3> real_radiosity) const {
  RequireFaceCount("object_radiosity", object_radiosity.size(), object_faces_);
  RequireFaceCount("real_radiosity", real_radiosity.size(), real_faces_);
  std::vector<glm::vec3> radiosity(object_radiosity.begin(), object_radiosity.end());
  radiosity.insert(radiosity.end(), real_radiosity.begin(), real_radiosity.end());
  std::vector<glm::vec3> at_vertices(VertexCount());
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t part) {
    const std::vector<glm::vec3> of_part = IrradianceOf(part, sky, radiosity);
    std::copy(of_part.begin(),
              of_part.end(),
              at_vertices.begin() + static_cast<std::ptrdiff_t>(VerticesOf(part).begin));
  });
  Fill(buried_, at_vertices);
  return at_vertices;
}

}  // namespace pleinair
