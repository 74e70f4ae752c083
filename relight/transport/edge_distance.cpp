#include "relight/transport/edge_distance.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

// Calls visit(pixel, neighbour) for each pixel and its right and lower neighbour.
template <class Visit>
void ForNeighbours(int width, int height, bool wraps_x, const Visit& visit) {
  const auto index = [width](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width) visit(index(x, y), index(x + 1, y));
      if (x + 1 == width && wraps_x) visit(index(x, y), index(0, y));
      if (y + 1 < height) visit(index(x, y), index(x, y + 1));
    }
  }
}

}  // namespace

Gray8Image MeshEdges(const SurfaceView& view, const glm::vec3& origin_m, bool wraps_x) {
  Gray8Image edges(view.Width(), view.Height(), 0);
  ForNeighbours(view.Width(), view.Height(), wraps_x, [&](std::size_t a, std::size_t b) {
    bool jumps = view.region.pixels[a] != view.region.pixels[b];
    if (!jumps && view.region.pixels[a] != SurfaceView::kNoRegion) {
      const glm::vec3& position = view.position_world_m.pixels[a];
      jumps = !SamePlane(position,
                         view.normal_world.pixels[a],
                         view.position_world_m.pixels[b],
                         view.normal_world.pixels[b],
                         glm::distance(position, origin_m));
    }
    if (jumps) edges.pixels[a] = edges.pixels[b] = 255;
  });
  return edges;
}

void AddShadowEdges(const SurfaceView& view,
                    const GrayImage& sun_visibility,
                    bool wraps_x,
                    Gray8Image& edges) {
  ForNeighbours(view.Width(), view.Height(), wraps_x, [&](std::size_t a, std::size_t b) {
    const bool surfaces = view.region.pixels[a] != SurfaceView::kNoRegion &&
                          view.region.pixels[b] != SurfaceView::kNoRegion;
    if (surfaces && sun_visibility.pixels[a] != sun_visibility.pixels[b]) {
      edges.pixels[a] = edges.pixels[b] = 255;
    }
  });
}

GrayImage DistanceTo(const Gray8Image& edges, bool wraps_x, bool border_is_edge) {
  const int width = edges.width;
  const int height = edges.height;
  // A quarter turn on either side is farther than any distance that is of use.
  const int pad_x = wraps_x ? std::max(1, width / 4) : 1;
  const int pad_y = 1;
  const std::uint8_t outside = border_is_edge ? 0 : 255;
  cv::Mat free_of_edges(height + 2 * pad_y, width + 2 * pad_x, CV_8U, cv::Scalar(outside));
  bool any = border_is_edge;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* row = free_of_edges.ptr<std::uint8_t>(y + pad_y);
    for (int x = -pad_x; x < width + pad_x; ++x) {
      if (!wraps_x && (x < 0 || x >= width)) continue;
      const bool edge = edges.At((x + width) % width, y) != 0;
      row[x + pad_x] = edge ? 0 : 255;
      any = any || edge;
    }
  }
  GrayImage distance(width, height, static_cast<float>(std::max(width, height)));
  if (!any) return distance;
  cv::Mat transformed;
  cv::distanceTransform(free_of_edges, transformed, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  for (int y = 0; y < height; ++y) {
    const float* row = transformed.ptr<float>(y + pad_y);
    std::copy(row + pad_x, row + pad_x + width, &distance.At(0, y));
  }
  return distance;
}

}  // namespace pleinair
