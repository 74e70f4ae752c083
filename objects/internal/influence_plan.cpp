#include "objects/internal/influence_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// What an object covers has no receiver. Where its edge lets the surface shine through, one within
// a block of three is found.
constexpr std::size_t kCoveredSize = 1;
// Largest side of a block on the surface, as a share of the distance to the object's own surface:
// by size, from the second on. Over the distance itself the object's share of the view changes by
// about all of it. The smallest block averages out as much of single rays' error as it adds. Far
// off the object's share falls with the cube of the distance; a linear blend over a share k of the
// distance is up to 3/2 k^2 too large.
constexpr std::array<float, kInfluenceBlocksPx.size() - 1> kBlockPerDistance{0.5f, 0.4f, 0.3f};
// Spacing on faces per distance.
constexpr float kSpacingPerDistance = 0.25f;
// Most receivers on a face's edge: 8000 on a face. A patch is at most some ten times as large as an
// object there.
constexpr float kMostParts = 128.0f;

// Squares of pixels that are planned together, of neighbours near each other.
constexpr int kTilePx = 8;

// A pixel's block: the largest one that is small beside the distance to the nearest object.
std::size_t SizeFor(float distance_m, float pixel_m) {
  std::size_t size = 0;
  while (size < kBlockPerDistance.size() &&
         static_cast<float>(kInfluenceBlocksPx[size + 1]) * pixel_m <
             kBlockPerDistance[size] * distance_m) {
    ++size;
  }
  return size;
}

// Sizes of blocks by the distance to the objects' surfaces. The distance at one point bounds it for
// those around it, which spares searches.
class BlockSizes {
 public:
  explicit BlockSizes(const RayCaster& objects) : objects_(objects) {}

  // `least_m` is no more than the distance.
  std::size_t At(const glm::vec3& position_m, float pixel_m, float least_m) {
    constexpr std::size_t kLargest = kInfluenceBlocksPx.size() - 1;
    if (SizeFor(least_m, pixel_m) == kLargest) return kLargest;
    if (has_anchor_) {
      const float apart_m = glm::distance(position_m, anchor_m_);
      const std::size_t size = SizeFor(std::max(anchor_distance_m_ - apart_m, least_m), pixel_m);
      if (size == kLargest || apart_m < kAnchorReach * anchor_distance_m_ ||
          size == SizeFor(anchor_distance_m_ + apart_m, pixel_m)) {
        return size;
      }
    }
    has_anchor_ = true;
    anchor_m_ = position_m;
    anchor_distance_m_ = objects_.DistanceTo(position_m, std::numeric_limits<float>::max());
    return SizeFor(anchor_distance_m_, pixel_m);
  }

 private:
  // Within this share of the anchor's distance, the lower bound is used without a new search.
  static constexpr float kAnchorReach = 0.125f;

  const RayCaster& objects_;
  glm::vec3 anchor_m_{0.0f};
  float anchor_distance_m_ = 0.0f;
  bool has_anchor_ = false;
};

// Whether the objects may fill more than a share of a surface's view; most pixels need no exact
// bound. A cone whose half angle's squared sine is s, up to a half, fills 2 s / (1 + sqrt(1 - s))
// at most, and s times the cosine at its axis at least.
bool MayFill(const std::vector<std::optional<ObjectBounds>>& bounds,
             const glm::vec3& position_m,
             const glm::vec3& normal,
             float least_share) {
  constexpr float kSharePerSquaredSine = 1.18f;
  float squared_sines = 0.0f;
  for (const std::optional<ObjectBounds>& object : bounds) {
    if (!object) continue;
    const glm::vec3 apart_m = object->centre_m - position_m;
    const float squared_sine = object->radius_m * object->radius_m / glm::dot(apart_m, apart_m);
    if (squared_sine < 1.0f &&
        squared_sine * glm::dot(normal, apart_m) > least_share * glm::length(apart_m)) {
      return true;
    }
    squared_sines += squared_sine;
  }
  if (kSharePerSquaredSine * squared_sines < std::min(least_share, 0.5f)) return false;
  float share = 0.0f;
  for (const std::optional<ObjectBounds>& object : bounds) {
    if (object) share += ObjectCone(*object, position_m).LargestShare(normal);
  }
  return share > least_share;
}

// Whether an object stands between the eye and a surface; `from_eye` are the cones in which the
// objects are seen from there.
bool IsCovered(const RayCaster& objects,
               std::span<const ObjectCone> from_eye,
               const glm::vec3& eye_m,
               const glm::vec3& position_m,
               const glm::vec3& normal) {
  const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
  const glm::vec3 to_eye_m = eye_m - start_m;
  const float range_m = glm::length(to_eye_m);
  const glm::vec3 to_eye = to_eye_m / range_m;
  // By more than rounding.
  const bool may_be = std::any_of(from_eye.begin(), from_eye.end(), [&](const ObjectCone& cone) {
    return glm::dot(to_eye, cone.axis) < cone.one_minus_cos - 1.0f + 1e-5f;
  });
  return may_be && objects.Occluded(start_m, to_eye, range_m);
}

}  // namespace

PixelPlan PlanPixels(const PatchScene& objects,
                     const std::vector<std::optional<ObjectBounds>>& bounds,
                     const SurfaceView& view,
                     float least_share,
                     float coarseness) {
  PixelPlan plan{Gray8Image(view.Width(), view.Height(), 0),
                 Gray8Image(view.Width(), view.Height(), 0)};
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const auto focal_px =
      static_cast<float>(std::sqrt(view.camera.intrinsics.fx_px * view.camera.intrinsics.fy_px));
  std::vector<ObjectCone> from_eye;
  for (const std::optional<ObjectBounds>& object : bounds) {
    if (object) from_eye.emplace_back(*object, eye_m);
  }
  const auto plan_pixel = [&](std::size_t pixel, BlockSizes& sizes) {
    const glm::vec3& position_m = view.position_world_m.pixels[pixel];
    const glm::vec3& normal = view.normal_world.pixels[pixel];
    if (!MayFill(bounds, position_m, normal, least_share)) return;
    const glm::vec3 to_eye_m = eye_m - position_m;
    const float range_m = glm::length(to_eye_m);
    const glm::vec3 to_eye = to_eye_m / range_m;
    float box_m = std::numeric_limits<float>::infinity();
    for (const std::optional<ObjectBounds>& object : bounds) {
      if (object) box_m = std::min(box_m, DistanceTo(object->box, position_m));
    }
    // The longer side of a pixel on the surface.
    const float cosine = std::abs(glm::dot(normal, to_eye));
    const float pixel_m = range_m / (coarseness * focal_px * std::max(cosine, 1e-3f));
    std::size_t size = sizes.At(position_m, pixel_m, box_m);
    if (IsCovered(objects.caster, from_eye, eye_m, position_m, normal)) {
      plan.covered.pixels[pixel] = 1;
      size = std::max(size, kCoveredSize);
    }
    plan.size.pixels[pixel] = static_cast<std::uint8_t>(1 + size);
  };
  tbb::parallel_for(0, (view.Height() + kTilePx - 1) / kTilePx, [&](int row) {
    for (int left = 0; left < view.Width(); left += kTilePx) {
      BlockSizes sizes(objects.caster);
      for (int y = row * kTilePx; y < std::min((row + 1) * kTilePx, view.Height()); ++y) {
        for (int x = left; x < std::min(left + kTilePx, view.Width()); ++x) {
          const std::size_t pixel = view.region.Index(x, y);
          if (view.region.pixels[pixel] != SurfaceView::kNoRegion) plan_pixel(pixel, sizes);
        }
      }
    }
  });
  return plan;
}

Gray8Image Candidates(const PixelPlan& plan, std::size_t size) {
  const int block_px = kInfluenceBlocksPx[size];
  const int width = plan.size.width;
  const int height = plan.size.height;
  Gray8Image has((width + block_px - 1) / block_px, (height + block_px - 1) / block_px, 0);
  tbb::parallel_for(0, has.height, [&](int row) {
    for (int y = row * block_px; y < std::min((row + 1) * block_px, height); ++y) {
      for (int x = 0; x < width; ++x) {
        if (plan.size.At(x, y) == 1 + size) has.At(x / block_px, row) = 1;
      }
    }
  });
  Gray8Image candidates(width, height, 0);
  tbb::parallel_for(0, has.height, [&](int row) {
    for (int column = 0; column < has.width; ++column) {
      bool is_around = false;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, has.height - 1); ++r) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, has.width - 1); ++c) {
          is_around |= has.At(c, r) != 0;
        }
      }
      if (!is_around) continue;
      for (int y = row * block_px; y < std::min((row + 1) * block_px, height); ++y) {
        for (int x = column * block_px; x < std::min((column + 1) * block_px, width); ++x) {
          candidates.At(x, y) = plan.size.At(x, y) != 0 && plan.covered.At(x, y) == 0 ? 1 : 0;
        }
      }
    }
  });
  return candidates;
}

std::vector<std::uint16_t> PartsOfFaces(const PatchScene& real,
                                        const std::vector<std::optional<ObjectBounds>>& bounds,
                                        float least_share,
                                        float coarseness,
                                        double least_spacing) {
  std::vector<std::uint16_t> parts(real.SideCount(), 0);
  tbb::parallel_for(std::size_t{0}, real.SideCount(), [&](std::size_t side) {
    const glm::uvec3& vertices = real.mesh.triangles[side / 2];
    std::array<glm::vec3, 4> points_m;
    for (int corner = 0; corner < 3; ++corner) {
      points_m[static_cast<std::size_t>(corner)] = real.mesh.positions_m[vertices[corner]];
    }
    points_m[3] = (points_m[0] + points_m[1] + points_m[2]) / 3.0f;
    const float edge_m = real.LongestEdgeM(real.PatchOf(side / 2));
    const glm::vec3 normal = real.SideNormal(side);
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
      spacing_m =
          std::min(spacing_m,
                   coarseness * std::max(kSpacingPerDistance * distance_m,
                                         static_cast<float>(least_spacing) * object->radius_m));
    }
    const bool matters = std::any_of(
        share.begin(), share.end(), [&](float at_point) { return at_point > least_share; });
    if (!matters && !near) return;
    // The boxes' corner that is farthest in front of the face's plane: more than rounding.
    const bool faces_one =
        std::any_of(bounds.begin(), bounds.end(), [&](const std::optional<ObjectBounds>& object) {
          if (!object) return false;
          const glm::vec3 farthest_m =
              glm::max(normal * object->box.lower_m, normal * object->box.upper_m);
          return farthest_m.x + farthest_m.y + farthest_m.z - glm::dot(normal, points_m[3]) >
                 1e-4f * object->radius_m;
        });
    if (!faces_one || !(edge_m > 0.0f)) return;
    parts[side] =
        static_cast<std::uint16_t>(std::clamp(std::ceil(edge_m / spacing_m), 1.0f, kMostParts));
  });
  return parts;
}

}  // namespace pleinair
