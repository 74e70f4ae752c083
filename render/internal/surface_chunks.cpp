#include "render/internal/surface_chunks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/vec4.hpp>

#include "render/internal/screen_extent.h"
#include "render/internal/view_projection.h"

namespace pleinair {
namespace {

// Few enough that chunks at the border of the view cost little, many enough that tests of boxes do.
constexpr std::size_t kTrianglesPerChunk = 256;

// An object that moves is sorted every frame: only where that takes less than drawing all of it.
constexpr std::size_t kMostUnsorted = 16384;

// The lowest ten bits, three apart.
std::uint32_t Spread(std::uint32_t value) {
  value = (value | (value << 16)) & 0x030000ffu;
  value = (value | (value << 8)) & 0x0300f00fu;
  value = (value | (value << 4)) & 0x030c30c3u;
  return (value | (value << 2)) & 0x09249249u;
}

// Place on a curve along which neighbours are near each other (Morton 1966).
std::uint32_t PlaceOnCurve(const glm::vec3& share_of_box) {
  constexpr float kCells = 1024.0f;
  const glm::uvec3 cell(glm::clamp(share_of_box * kCells, glm::vec3(0.0f), glm::vec3(kCells - 1)));
  return Spread(cell.x) | (Spread(cell.y) << 1) | (Spread(cell.z) << 2);
}

BoundingBox BoxOf(std::span<const glm::vec3> positions_m, std::span<const glm::uvec3> triangles) {
  BoundingBox box{positions_m[triangles.front().x], positions_m[triangles.front().x]};
  for (const glm::uvec3& triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      box.lower_m = glm::min(box.lower_m, positions_m[triangle[corner]]);
      box.upper_m = glm::max(box.upper_m, positions_m[triangle[corner]]);
    }
  }
  return box;
}

// Whether all of a box lies beyond one of the sides of the clip volume, or behind the camera.
bool IsOut(const BoundingBox& box, const glm::mat4& clip_from_position) {
  // More than rounding.
  constexpr float kMargin = 1e-3f;
  std::array<int, 5> beyond{};
  for (const glm::vec3& corner : CornersOf(box)) {
    const glm::vec4 clip = clip_from_position * glm::vec4(corner, 1.0f);
    const float margin = kMargin * glm::max(std::abs(clip.w), 1.0f);
    beyond[0] += clip.x < -clip.w - margin ? 1 : 0;
    beyond[1] += clip.x > clip.w + margin ? 1 : 0;
    beyond[2] += clip.y < -clip.w - margin ? 1 : 0;
    beyond[3] += clip.y > clip.w + margin ? 1 : 0;
    beyond[4] += clip.w < -margin ? 1 : 0;
  }
  return std::find(beyond.begin(), beyond.end(), 8) != beyond.end();
}

}  // namespace

SurfaceChunks::SurfaceChunks(std::span<const glm::vec3> positions_m,
                             std::span<const glm::uvec3> triangles)
    : positions_m_(positions_m.begin(), positions_m.end()),
      triangles_(triangles.begin(), triangles.end()) {
  if (triangles_.empty()) return;
  if (triangles_.size() > kMostUnsorted) {
    const BoundingBox box = BoxOf(positions_m_, triangles_);
    const glm::vec3 size_m = glm::max(box.upper_m - box.lower_m, glm::vec3(1e-6f));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
    places.reserve(triangles_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const glm::uvec3& v = triangles_[i];
      const glm::vec3 middle_m = (positions_m_[v.x] + positions_m_[v.y] + positions_m_[v.z]) / 3.0f;
      places.emplace_back(PlaceOnCurve((middle_m - box.lower_m) / size_m),
                          static_cast<std::uint32_t>(i));
    }
    std::sort(places.begin(), places.end());
    for (std::size_t i = 0; i < places.size(); ++i) triangles_[i] = triangles[places[i].second];
  }
  for (std::size_t first = 0; first < triangles_.size(); first += kTrianglesPerChunk) {
    const Range range{first, std::min(kTrianglesPerChunk, triangles_.size() - first)};
    chunks_.push_back(
        {range, BoxOf(positions_m_, std::span(triangles_).subspan(range.first, range.count))});
  }
}

std::vector<SurfaceChunks::Range> SurfaceChunks::InView(const glm::mat4& clip_from_position) const {
  std::vector<Range> in_view;
  for (const Chunk& chunk : chunks_) {
    if (IsOut(chunk.box, clip_from_position)) continue;
    if (!in_view.empty() && in_view.back().first + in_view.back().count == chunk.range.first) {
      in_view.back().count += chunk.range.count;
    } else {
      in_view.push_back(chunk.range);
    }
  }
  return in_view;
}

double SurfaceChunks::NearestInViewM(const CameraIntrinsics& intrinsics,
                                     const glm::dmat4& camera_from_position) const {
  struct NearChunk {
    double least_m;
    const Chunk* chunk;
  };
  // Only the sides of the view count: the near plane is anywhere.
  constexpr double kAnyNearPlaneM = 1.0;
  const glm::mat4 clip_from_position(ClipFromCamera(intrinsics, kAnyNearPlaneM) *
                                     camera_from_position);
  std::vector<NearChunk> by_depth;
  for (const Chunk& chunk : chunks_) {
    if (IsOut(chunk.box, clip_from_position)) continue;
    double least_m = std::numeric_limits<double>::infinity();
    for (const glm::vec3& corner : CornersOf(chunk.box)) {
      least_m = std::min(least_m, (camera_from_position * glm::dvec4(glm::dvec3(corner), 1.0)).z);
    }
    by_depth.push_back({least_m, &chunk});
  }
  std::sort(by_depth.begin(), by_depth.end(), [](const NearChunk& a, const NearChunk& b) {
    return a.least_m < b.least_m;
  });
  double nearest_m = std::numeric_limits<double>::infinity();
  std::vector<glm::vec3> corners_m;
  std::vector<glm::uvec3> triangles;
  for (const auto& [least_m, chunk] : by_depth) {
    if (least_m >= nearest_m) break;
    corners_m.clear();
    triangles.clear();
    for (std::size_t i = 0; i < chunk->range.count; ++i) {
      const auto first = static_cast<std::uint32_t>(corners_m.size());
      const glm::uvec3& v = triangles_[chunk->range.first + i];
      corners_m.insert(corners_m.end(), {positions_m_[v.x], positions_m_[v.y], positions_m_[v.z]});
      triangles.emplace_back(first, first + 1, first + 2);
    }
    nearest_m = std::min(
        nearest_m, ExtentOf(corners_m, triangles, intrinsics, camera_from_position).nearest_m);
  }
  return nearest_m;
}

}  // namespace pleinair
