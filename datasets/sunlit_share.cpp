#include "datasets/sunlit_share.h"

#include <algorithm>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "datasets/diffuse_mask.h"

namespace pleinair {
namespace {

std::vector<std::uint8_t> DiffuseTriangles(const Sequence& sequence, const Mesh& mesh) {
  const std::vector<std::string>& names = sequence.diffuse_regions;
  const auto is_named = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::vector<std::uint8_t> diffuse(mesh.triangles.size(), names.empty() ? 1 : 0);
  for (std::size_t t = 0; t < diffuse.size() && !names.empty(); ++t) {
    diffuse[t] = is_named(mesh.group_names[mesh.triangle_group[t]]) ||
                         is_named(mesh.materials[mesh.triangle_material[t]].name)
                     ? 1
                     : 0;
  }
  return diffuse;
}

std::optional<Gray8Image> PictureMask(const Sequence& sequence) {
  if (!sequence.diffuse_mask) return std::nullopt;
  for (const FrameEntry& frame : sequence.frames) {
    if (frame.camera_from_world && sequence.frames.size() > 1) return std::nullopt;
  }
  auto mask = ReadDiffuseMask(sequence);
  if (!mask || mask->is_over_map) return std::nullopt;
  return std::move(mask->image);
}

// Calls visit(x, y, direction_world) for every pixel that has a direction.
template <typename Visit>
void ForEachPixelRay(const Camera& camera, const Visit& visit) {
  const Lens lens(camera.intrinsics);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < camera.intrinsics.height_px; ++y) {
    for (int x = 0; x < camera.intrinsics.width_px; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) continue;
      visit(x, y, glm::vec3(glm::normalize(world_from_camera * *direction)));
    }
  }
}

}  // namespace

SunlitCounter::SunlitCounter(const Sequence& sequence, const Mesh& mesh)
    : caster_(mesh),
      triangle_is_diffuse_(DiffuseTriangles(sequence, mesh)),
      mask_(PictureMask(sequence)) {}

void SunlitCounter::See(const Camera& camera) {
  seen_.clear();
  const glm::vec3 centre(camera.CentreWorldM());
  ForEachPixelRay(camera, [&](int x, int y, const glm::vec3& direction) {
    if (mask_ && mask_->At(x, y) != 255) return;
    const auto hit = caster_.Intersect(centre, direction);
    if (!hit || triangle_is_diffuse_[hit->triangle] == 0) return;
    const glm::vec3 normal = glm::dot(hit->geometric_normal, direction) > 0.0f
                                 ? -hit->geometric_normal
                                 : hit->geometric_normal;
    seen_.push_back({OffsetFromSurface(hit->position_m, normal), normal});
  });
  camera_ = camera;
}

SunlitShare SunlitCounter::Count(const Camera& camera, const glm::dvec3& sun_direction_enu) {
  if (!camera_ || !(*camera_ == camera)) See(camera);
  SunlitShare share;
  share.diffuse_pixels = static_cast<int>(seen_.size());
  if (seen_.empty()) return share;
  const glm::vec3 sun(sun_direction_enu);
  int lit = 0;
  for (const Seen& seen : seen_) {
    if (!(sun.z > 0.0f) || !(glm::dot(seen.normal, sun) > 0.0f)) continue;
    lit += caster_.Occluded(seen.start_m, sun) ? 0 : 1;
  }
  share.lit = static_cast<double>(lit) / share.diffuse_pixels;
  return share;
}

std::optional<Gray8Image> SpecularPixels(const std::vector<Mesh>& objects,
                                         const RayCaster& phantom,
                                         const Camera& camera) {
  bool any = false;
  for (const Mesh& object : objects) {
    for (const Material& material : object.materials) {
      any = any || material.specular_reflectance != glm::vec3(0.0f);
    }
  }
  if (!any) return std::nullopt;

  std::vector<RayCaster> casters;
  casters.reserve(objects.size());
  for (const Mesh& object : objects) casters.emplace_back(object);
  const int width = camera.intrinsics.width_px;
  const int height = camera.intrinsics.height_px;
  Gray8Image specular(width, height);
  const glm::vec3 centre(camera.CentreWorldM());
  ForEachPixelRay(camera, [&](int x, int y, const glm::vec3& direction) {
    float nearest_m = std::numeric_limits<float>::infinity();
    bool mirrors = false;
    for (std::size_t k = 0; k < objects.size(); ++k) {
      const auto hit = casters[k].Intersect(centre, direction, nearest_m);
      if (!hit) continue;
      nearest_m = hit->distance_m;
      const Material& material = objects[k].materials[objects[k].triangle_material[hit->triangle]];
      mirrors = material.specular_reflectance != glm::vec3(0.0f);
    }
    if (!mirrors || phantom.Occluded(centre, direction, nearest_m)) return;
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
        specular.At(u, v) = 1;
      }
    }
  });
  return specular;
}

}  // namespace pleinair
