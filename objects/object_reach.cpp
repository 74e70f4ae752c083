#include "objects/object_reach.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "calib/lens.h"
#include "objects/internal/object_cone.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// A receiver's light is blended over the pixels around it: there the share differs, within a block
// by about this part of itself (see influence_plan.h).
constexpr float kBlendMargin = 4.0f;

float ShareAt(const std::vector<std::optional<ObjectBounds>>& bounds,
              const SurfaceView& view,
              std::size_t pixel) {
  float share = 0.0f;
  for (const std::optional<ObjectBounds>& object : bounds) {
    if (!object) continue;
    share += ObjectCone(*object, view.position_world_m.pixels[pixel])
                 .LargestShare(view.normal_world.pixels[pixel]);
  }
  return std::min(share, 1.0f);
}

}  // namespace

bool MayBeInView(const PatchScene& objects, const Camera& camera) {
  const CameraIntrinsics picture = UndistortedCover(camera.intrinsics);
  for (const std::optional<ObjectBounds>& object : BoundsOfObjects(objects.mesh)) {
    if (!object) continue;
    glm::dvec2 lower(std::numeric_limits<double>::infinity());
    glm::dvec2 upper(-std::numeric_limits<double>::infinity());
    int before = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const BoundingBox& box = object->box;
      const glm::dvec4 corner_m((corner & 1) != 0 ? box.upper_m.x : box.lower_m.x,
                                (corner & 2) != 0 ? box.upper_m.y : box.lower_m.y,
                                (corner & 4) != 0 ? box.upper_m.z : box.lower_m.z,
                                1.0);
      const glm::dvec3 at(camera.camera_from_world * corner_m);
      if (!(at.z > 0.0)) continue;
      ++before;
      const glm::dvec2 pixel(picture.fx_px * at.x / at.z + picture.cx_px,
                             picture.fy_px * at.y / at.z + picture.cy_px);
      lower = glm::min(lower, pixel);
      upper = glm::max(upper, pixel);
    }
    if (before == 0) continue;
    // A box that reaches behind the camera may show anywhere.
    if (before < 8) return true;
    // A pixel of margin, for what an edge blends.
    if (upper.x >= -1.5 && lower.x <= picture.width_px + 0.5 && upper.y >= -1.5 &&
        lower.y <= picture.height_px + 0.5) {
      return true;
    }
  }
  return false;
}

InfluenceReach ReachOfInfluence(const PatchScene& objects,
                                const SurfaceView& view,
                                const ObjectInfluenceOptions& options) {
  const std::vector<std::optional<ObjectBounds>> bounds = BoundsOfObjects(objects.mesh);
  InfluenceReach reach;
  constexpr int kStep = 4;
  for (int y = kStep / 2; y < view.Height(); y += kStep) {
    for (int x = kStep / 2; x < view.Width(); x += kStep) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      if (ShareAt(bounds, view, pixel) > InfluenceReach::kDecisive) {
        reach.largest_share = 1.0f;
        return reach;
      }
    }
  }
  struct Row {
    float largest_share = 0.0f;
    std::vector<std::uint32_t> pixels;
  };
  const auto least_share = static_cast<float>(options.least_share);
  std::vector<Row> rows(static_cast<std::size_t>(view.Height()));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    Row& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      const float share = ShareAt(bounds, view, pixel);
      if (!(kBlendMargin * share > least_share)) continue;
      row.largest_share = std::max(row.largest_share, share);
      row.pixels.push_back(static_cast<std::uint32_t>(pixel));
    }
  });
  for (const Row& row : rows) {
    reach.largest_share = std::max(reach.largest_share, row.largest_share);
    reach.pixels.insert(reach.pixels.end(), row.pixels.begin(), row.pixels.end());
  }
  reach.largest_share = std::min(kBlendMargin * reach.largest_share, 1.0f);
  return reach;
}

bool AnySeesSun(const PatchScene& objects, const RayCaster& real, const DirectionalLight& sun) {
  const glm::dvec3 centre = glm::normalize(sun.direction_enu);
  if (centre.z < -std::sin(sun.angular_radius_rad)) return false;
  const NormalFrame frame{glm::vec3(centre)};
  const double tangent_radius = std::tan(sun.angular_radius_rad);
  std::array<glm::vec3, 5> points{glm::vec3(centre)};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double sign = i % 2 == 0 ? -tangent_radius : tangent_radius;
    points[i] = glm::vec3(
        glm::normalize(centre + sign * glm::dvec3(i < 3 ? frame.tangent : frame.bitangent)));
  }
  std::vector<glm::vec3> from_m = objects.mesh.positions_m;
  const std::size_t vertices = from_m.size();
  for (const glm::uvec3& corners : objects.mesh.triangles) {
    from_m.push_back((from_m[corners.x] + from_m[corners.y] + from_m[corners.z]) / 3.0f);
  }
  std::atomic<bool> any = false;
  for (std::size_t point = 0; point < points.size(); ++point) {
    const glm::vec3& to_sun = points[point];
    // A run at a time: their rays are parallel.
    constexpr std::size_t kRun = 256;
    const std::size_t count = point == 0 ? from_m.size() : vertices;
    tbb::parallel_for(std::size_t{0}, (count + kRun - 1) / kRun, [&](std::size_t run) {
      if (any.load(std::memory_order_relaxed)) return;
      const std::size_t first = run * kRun;
      const std::size_t size = std::min(kRun, count - first);
      std::array<glm::vec3, kRun> origins_m{};
      std::array<glm::vec3, kRun> directions{};
      std::array<bool, kRun> occluded{};
      for (std::size_t i = 0; i < size; ++i) {
        // Where the object touches a wall or the ground, its point is just before it.
        origins_m[i] = OffsetFromSurface(from_m[first + i], to_sun);
        directions[i] = to_sun;
      }
      real.Occluded(origins_m.data(), directions.data(), size, occluded.data());
      if (std::find(occluded.begin(),
                    occluded.begin() + static_cast<std::ptrdiff_t>(size),
                    false) != occluded.begin() + static_cast<std::ptrdiff_t>(size)) {
        any.store(true, std::memory_order_relaxed);
      }
    });
    if (any) return true;
  }
  return false;
}

}  // namespace pleinair
