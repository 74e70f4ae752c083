#include "relight/transport/edge_distance.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

constexpr std::uint8_t kEdge = 255;

// Whether a pixel and one of its four neighbours differ: differ(a, b), of which `a` is the left or
// upper one.
class Neighbours {
 public:
  Neighbours(int width, int height, bool wraps_x)
      : width_(width), height_(height), wraps_x_(wraps_x) {}

  template <class Differ>
  bool AnyDiffers(int x, int y, const Differ& differ) const {
    const std::size_t own = Index(x, y);
    const std::optional<int> left = x > 0 ? x - 1 : Wrapped(width_ - 1);
    const std::optional<int> right = x + 1 < width_ ? x + 1 : Wrapped(0);
    return (left && differ(Index(*left, y), own)) || (right && differ(own, Index(*right, y))) ||
           (y > 0 && differ(Index(x, y - 1), own)) ||
           (y + 1 < height_ && differ(own, Index(x, y + 1)));
  }

 private:
  std::optional<int> Wrapped(int x) const {
    return wraps_x_ ? std::optional<int>(x) : std::nullopt;
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  bool wraps_x_;
};

class MeshJump {
 public:
  MeshJump(const SurfaceView& view, const glm::vec3& origin_m) : view_(view), origin_m_(origin_m) {}

  bool operator()(std::size_t a, std::size_t b) const {
    if (view_.region.pixels[a] != view_.region.pixels[b]) return true;
    if (view_.region.pixels[a] == SurfaceView::kNoRegion) return false;
    const glm::vec3& position = view_.position_world_m.pixels[a];
    return !SamePlane(position,
                      view_.normal_world.pixels[a],
                      view_.position_world_m.pixels[b],
                      view_.normal_world.pixels[b],
                      glm::distance(position, origin_m_));
  }

 private:
  const SurfaceView& view_;
  glm::vec3 origin_m_;
};

// Whether a block and all around it show one plane each: as they share corners, all the same one.
bool IsAmidPlane(const PlanarBlocks& planar, int column, int row) {
  const PixelBlocks& blocks = planar.blocks;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, blocks.Rows() - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, blocks.Columns() - 1); ++x) {
      if (planar.is_planar[blocks.Index(x, y)] == 0) return false;
    }
  }
  return true;
}

}  // namespace

Gray8Image MeshEdges(const SurfaceView& view, const glm::vec3& origin_m, bool wraps_x) {
  Gray8Image edges(view.Width(), view.Height(), 0);
  const Neighbours neighbours(view.Width(), view.Height(), wraps_x);
  const MeshJump jump(view, origin_m);
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (neighbours.AnyDiffers(x, y, jump)) edges.At(x, y) = kEdge;
    }
  });
  return edges;
}

void MeshEdgesInBlocks(const SurfaceView& view,
                       const glm::vec3& origin_m,
                       const PlanarBlocks& planar,
                       Gray8Image& edges) {
  const PixelBlocks& blocks = planar.blocks;
  if (blocks.SidePx() == 1) {
    edges = MeshEdges(view, origin_m, false);
    return;
  }
  SizeFor(blocks, edges);
  const Neighbours neighbours(view.Width(), view.Height(), false);
  const MeshJump jump(view, origin_m);
  tbb::parallel_for(0, blocks.Rows(), [&](int row) {
    for (int column = 0; column < blocks.Columns(); ++column) {
      const PixelBlocks::Work work = blocks.WorkOf(blocks.Index(column, row));
      if (work == PixelBlocks::Work::kKept) continue;
      const PixelBlock block = blocks.At(column, row);
      const bool has_no_edge =
          work == PixelBlocks::Work::kBlanked || IsAmidPlane(planar, column, row);
      for (int y = block.top; y < block.end_y; ++y) {
        for (int x = block.left; x < block.end_x; ++x) {
          const bool is_edge = !has_no_edge && neighbours.AnyDiffers(x, y, jump);
          edges.At(x, y) = is_edge ? kEdge : 0;
        }
      }
    }
  });
}

void AddShadowEdges(const SurfaceView& view,
                    const GrayImage& sun_visibility,
                    bool wraps_x,
                    Gray8Image& edges) {
  const Neighbours neighbours(view.Width(), view.Height(), wraps_x);
  const auto differ = [&](std::size_t a, std::size_t b) {
    return sun_visibility.pixels[a] != sun_visibility.pixels[b] &&
           view.region.pixels[a] != SurfaceView::kNoRegion &&
           view.region.pixels[b] != SurfaceView::kNoRegion;
  };
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (neighbours.AnyDiffers(x, y, differ)) edges.At(x, y) = kEdge;
    }
  });
}

GrayImage DistanceTo(const Gray8Image& edges, bool wraps_x) {
  const int width = edges.width;
  const int height = edges.height;
  GrayImage distance(width, height, static_cast<float>(std::max(width, height)));
  // A quarter turn on either side is farther than any distance that is of use.
  const int pad_x = wraps_x ? std::max(1, width / 4) : 0;
  cv::Mat free_of_edges(height, width + 2 * pad_x, CV_8U);
  bool any = false;
  for (int y = 0; y < height; ++y) {
    auto* row = free_of_edges.ptr<std::uint8_t>(y);
    for (int x = -pad_x; x < width + pad_x; ++x) {
      const bool edge = edges.At((x + width) % width, y) != 0;
      row[x + pad_x] = edge ? 0 : 255;
      any = any || edge;
    }
  }
  if (!any) return distance;
  cv::Mat transformed;
  cv::distanceTransform(free_of_edges, transformed, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  for (int y = 0; y < height; ++y) {
    const auto* row = transformed.ptr<float>(y);
    std::copy(row + pad_x, row + pad_x + width, &distance.At(0, y));
  }
  return distance;
}

void DistanceToEdgeOrBorder(const Gray8Image& edges, GrayImage& distance_px) {
  const int width = edges.width;
  const int height = edges.height;
  distance_px.width = width;
  distance_px.height = height;
  distance_px.pixels.resize(edges.pixels.size());
  if (edges.pixels.empty()) return;
  cv::Mat free_of_edges(height, width, CV_8U);
  tbb::parallel_for(0, height, [&](int y) {
    auto* row = free_of_edges.ptr<std::uint8_t>(y);
    for (int x = 0; x < width; ++x) row[x] = edges.At(x, y) != 0 ? 0 : 255;
  });
  cv::Mat distance(height, width, CV_32F, distance_px.pixels.data());
  cv::distanceTransform(free_of_edges, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  tbb::parallel_for(0, height, [&](int y) {
    const int to_rows = std::min(y + 1, height - y);
    for (int x = 0; x < width; ++x) {
      const int to_border = std::min({x + 1, width - x, to_rows});
      float& own = distance_px.At(x, y);
      own = std::min(own, static_cast<float>(to_border));
    }
  });
}

}  // namespace pleinair
