#include "objects/internal/own_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace pleinair {
namespace {

glm::vec3 MiddleOf(const Mesh& mesh, std::size_t face) {
  const glm::uvec3& corners = mesh.triangles[face / 2];
  return (mesh.positions_m[corners.x] + mesh.positions_m[corners.y] + mesh.positions_m[corners.z]) /
         3.0f;
}

}  // namespace

std::size_t OwnShape::CellOf(const glm::vec3& direction) {
  const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
  float u = direction.x / sum;
  float v = direction.y / sum;
  if (direction.z < 0.0f) {
    const float folded = (1.0f - std::abs(v)) * (u < 0.0f ? -1.0f : 1.0f);
    v = (1.0f - std::abs(u)) * (v < 0.0f ? -1.0f : 1.0f);
    u = folded;
  }
  const auto step = [](float at) {
    const int i = static_cast<int>((0.5f * at + 0.5f) * static_cast<float>(kCellsASide));
    return static_cast<std::size_t>(std::clamp(i, 0, kCellsASide - 1));
  };
  return step(v) * kCellsASide + step(u);
}

OwnShape::OwnShape(const ObjectGather& gather,
                   const PatchScene& objects,
                   std::span<const glm::mat3> own_from_world)
    : object_of_vertex_(gather.VertexCount(), 0), parts_(gather.PartCount()) {
  for (std::size_t t = 0; t < objects.mesh.triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      object_of_vertex_[objects.mesh.triangles[t][corner]] = objects.mesh.triangle_group[t];
    }
  }
  std::vector<std::size_t> all(parts_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Refine(gather, all, objects, own_from_world);
}

void OwnShape::Refine(const ObjectGather& gather,
                      std::span<const std::size_t> parts,
                      const PatchScene& objects,
                      std::span<const glm::mat3> own_from_world) {
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    Part& part = parts_[parts[i]];
    if (part.rays_per_vertex >= gather.RaysPerVertex()) return;
    part = PartOf(gather, parts[i], objects, own_from_world);
  });
}

OwnShape::Part OwnShape::PartOf(const ObjectGather& gather,
                                std::size_t index,
                                const PatchScene& objects,
                                std::span<const glm::mat3> own_from_world) const {
  Part part;
  part.rays_per_vertex = gather.RaysPerVertex();
  const auto [first, last] = gather.VerticesOf(index);
  std::vector<Source> faces;
  for (std::size_t v = first; v < last; ++v) {
    const std::uint32_t object = object_of_vertex_[v];
    std::array<float, kCells> shares{};
    faces.clear();
    const auto add_direction = [&](const glm::vec3& direction, float share) {
      shares[CellOf(own_from_world[object] * direction)] += share;
    };
    gather.ForSources(
        v,
        [&](const glm::vec3& point_m, std::size_t face, float share) {
          if (objects.mesh.triangle_group[face / 2] == object) {
            faces.push_back({static_cast<std::uint32_t>(face), share});
            return;
          }
          const glm::vec3 to_middle_m = MiddleOf(objects.mesh, face) - point_m;
          const float distance_m = glm::length(to_middle_m);
          if (distance_m > 0.0f) add_direction(to_middle_m / distance_m, share);
        },
        add_direction);
    std::sort(faces.begin(), faces.end(), [](const Source& a, const Source& b) {
      return a.index < b.index;
    });
    std::size_t kept = 0;  // Each face once: a vertex's points see the same ones.
    for (std::size_t i = 1; i < faces.size(); ++i) {
      if (faces[i].index == faces[kept].index) {
        faces[kept].share += faces[i].share;
      } else {
        faces[++kept] = faces[i];
      }
    }
    if (!faces.empty()) faces.resize(kept + 1);
    part.faces.sources.insert(part.faces.sources.end(), faces.begin(), faces.end());
    part.faces.begin.push_back(static_cast<std::uint32_t>(part.faces.sources.size()));
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      if (shares[cell] == 0.0f) continue;
      part.cells.sources.push_back(
          {static_cast<std::uint32_t>(object * kCells + cell), shares[cell]});
    }
    part.cells.begin.push_back(static_cast<std::uint32_t>(part.cells.sources.size()));
  }
  return part;
}

std::vector<glm::vec3> OwnShape::Sum(Rows Part::*rows,
                                     std::span<const glm::vec3> radiosity,
                                     std::size_t lights) const {
  std::vector<glm::vec3> sums(VertexCount() * lights, glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t part) {
    const auto& [begin, sources] = parts_[part].*rows;
    // Channel by channel: the compiler makes vector instructions of that.
    const std::size_t channels = 3 * lights;
    float* sum = glm::value_ptr(sums.data()[part * ObjectGather::kVerticesPerPart * lights]);
    for (std::size_t i = 0; i + 1 < begin.size(); ++i, sum += channels) {
      for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k) {
        const float* const source =
            glm::value_ptr(radiosity.data()[std::size_t{sources[k].index} * lights]);
        for (std::size_t c = 0; c < channels; ++c) sum[c] += sources[k].share * source[c];
      }
    }
  });
  return sums;
}

std::vector<glm::vec3> OwnShape::FromCells(std::span<const glm::vec3> cells,
                                           std::size_t lights) const {
  return Sum(&Part::cells, cells, lights);
}

std::vector<glm::vec3> OwnShape::FromFaces(std::span<const glm::vec3> faces,
                                           std::size_t lights) const {
  return Sum(&Part::faces, faces, lights);
}

}  // namespace pleinair
