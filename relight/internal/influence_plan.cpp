#include "relight/internal/influence_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// What an object covers has no receiver. Where its edge lets the surface shine through, one within
// a block of three is found.
constexpr std::size_t kCoveredSize = 1;
// A block's side on the surface is at most this share of the distance to the object, over which
// the object's share of the view changes by about as much of itself. Two fifths or a quarter: no
// pixel of the recordings differs by more than one code value.
constexpr float kBlockPerDistance = 0.4f;
// On faces likewise.
constexpr float kSpacingPerDistance = 0.25f;
// Of a face's edge: 8000 receivers. A patch is some ten times as large as what stands there at
// most.
constexpr float kMostParts = 128.0f;

}  // namespace

PixelPlan PlanPixels(const PatchScene& objects,
                     const std::vector<std::optional<ObjectBounds>>& bounds,
                     const SurfaceView& view) {
  PixelPlan plan{Gray8Image(view.Width(), view.Height(), 0),
                 Gray8Image(view.Width(), view.Height(), 0)};
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const auto focal_px =
      static_cast<float>(std::sqrt(view.camera.intrinsics.fx_px * view.camera.intrinsics.fy_px));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      const glm::vec3& position_m = view.position_world_m.pixels[pixel];
      const glm::vec3& normal = view.normal_world.pixels[pixel];
      float share = 0.0f;
      float distance_m = std::numeric_limits<float>::infinity();
      for (const std::optional<ObjectBounds>& object : bounds) {
        if (!object) continue;
        share += ObjectCone(*object, position_m).LargestShare(normal);
        distance_m = std::min(distance_m, DistanceTo(object->box, position_m));
      }
      if (!(share > kLeastInfluenceShare)) continue;
      // The longer side of a pixel on the surface.
      const float range_m = glm::distance(eye_m, position_m);
      const float cosine = std::abs(glm::dot(normal, position_m - eye_m)) / range_m;
      const float pixel_m = range_m / (focal_px * std::max(cosine, 1e-3f));
      std::size_t size = 0;
      while (size + 1 < kInfluenceBlocksPx.size() &&
             static_cast<float>(kInfluenceBlocksPx[size + 1]) * pixel_m <
                 kBlockPerDistance * distance_m) {
        ++size;
      }
      const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
      const glm::vec3 to_eye_m = eye_m - start_m;
      const float start_range_m = glm::length(to_eye_m);
      if (objects.caster.Occluded(start_m, to_eye_m / start_range_m, start_range_m)) {
        plan.covered.pixels[pixel] = 1;
        size = std::max(size, kCoveredSize);
      }
      plan.size.pixels[pixel] = static_cast<std::uint8_t>(1 + size);
    }
  });
  return plan;
}

Gray8Image Candidates(const PixelPlan& plan, std::size_t size) {
  const int block_px = kInfluenceBlocksPx[size];
  const int width = plan.size.width;
  const int height = plan.size.height;
  Gray8Image around((width + block_px - 1) / block_px, (height + block_px - 1) / block_px, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (plan.size.At(x, y) != 1 + size) continue;
      // A block of one pixel serves that pixel alone.
      const int margin = block_px > 1 ? 1 : 0;
      for (int row = y / block_px - margin; row <= y / block_px + margin; ++row) {
        for (int column = x / block_px - margin; column <= x / block_px + margin; ++column) {
          if (around.Contains(column, row)) around.At(column, row) = 1;
        }
      }
    }
  }
  Gray8Image candidates(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (around.At(x / block_px, y / block_px) == 0) continue;
      candidates.At(x, y) = plan.size.At(x, y) != 0 && plan.covered.At(x, y) == 0 ? 1 : 0;
    }
  }
  return candidates;
}

std::vector<std::uint16_t> PartsOfFaces(const PatchScene& real,
                                        const std::vector<std::optional<ObjectBounds>>& bounds,
                                        double least_spacing) {
  std::vector<std::uint16_t> parts(real.FaceCount(), 0);
  tbb::parallel_for(std::size_t{0}, real.FaceCount(), [&](std::size_t face) {
    const glm::uvec3& vertices = real.mesh.triangles[face / 2];
    std::array<glm::vec3, 4> points_m;
    for (int corner = 0; corner < 3; ++corner) {
      points_m[static_cast<std::size_t>(corner)] = real.mesh.positions_m[vertices[corner]];
    }
    points_m[3] = (points_m[0] + points_m[1] + points_m[2]) / 3.0f;
    float edge_m = 0.0f;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      edge_m = std::max(edge_m, glm::distance(points_m[corner], points_m[(corner + 1) % 3]));
    }
    const glm::vec3 normal = real.FaceNormal(face);
    std::array<float, 4> share{};
    float spacing_m = std::numeric_limits<float>::infinity();
    bool near = false;
    for (const std::optional<ObjectBounds>& object : bounds) {
      if (!object) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        share[k] += ObjectCone(*object, points_m[k]).LargestShare(normal);
      }
      // Between the points a triangle may be nearer by a part of its size.
      float distance_m = std::numeric_limits<float>::infinity();
      for (const glm::vec3& point_m : points_m) {
        distance_m = std::min(distance_m, DistanceTo(object->box, point_m));
      }
      distance_m = std::max(distance_m - 0.25f * edge_m, 0.0f);
      near |= distance_m < object->radius_m;
      spacing_m = std::min(spacing_m,
                           std::max(kSpacingPerDistance * distance_m,
                                    static_cast<float>(least_spacing) * object->radius_m));
    }
    const bool matters = std::any_of(
        share.begin(), share.end(), [](float at_point) { return at_point > kLeastInfluenceShare; });
    if (!matters && !near) return;
    // Of the boxes' corners the one farthest before the face's plane: more than rounding.
    const bool faces_one =
        std::any_of(bounds.begin(), bounds.end(), [&](const std::optional<ObjectBounds>& object) {
          if (!object) return false;
          const glm::vec3 farthest_m =
              glm::max(normal * object->box.lower_m, normal * object->box.upper_m);
          return farthest_m.x + farthest_m.y + farthest_m.z - glm::dot(normal, points_m[3]) >
                 1e-4f * object->radius_m;
        });
    if (!faces_one || !(edge_m > 0.0f)) return;
    parts[face] =
        static_cast<std::uint16_t>(std::clamp(std::ceil(edge_m / spacing_m), 1.0f, kMostParts));
  });
  return parts;
}

}  // namespace pleinair
