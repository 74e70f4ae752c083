// The planes that square blocks of a view's pixels show: light is gathered at one pixel a plane and
// blended over the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/transport/same_plane.h"
#include "relight/transport/transport.h"
#include "scene/surface_view.h"

namespace pleinair {

class PlaneBlocks {
 public:
  struct Options {
    int block_px = 4;
    // The first and last column are neighbours (lat-long maps).
    bool wraps_x = false;
    // Not 0 where a pixel may represent its plane; null: all that show a surface. Keeps nothing.
    const Gray8Image* candidates = nullptr;
  };

  // One receiver for each plane that a block shows, at the pixel nearest to the middle of what
  // shows it. `origin_m` is where the view is seen from. Keeps a reference to the view.
  PlaneBlocks(const SurfaceView& view, const glm::vec3& origin_m, const Options& options);

  const std::vector<Receiver>& Receivers() const { return receivers_; }
  // Per receiver, the pixel where it stands.
  const std::vector<std::size_t>& ReceiverPixels() const { return receiver_pixels_; }

  // Visits the receivers of the pixel's plane in the four blocks around it with their bilinear
  // weights, which add up to 1 only where all four show that plane: visit(receiver, weight). A
  // pixel's own block has a weight of a quarter at least.
  template <class Visit>
  void ForPixel(int x, int y, const Visit& visit) const {
    const Along& across = across_[static_cast<std::size_t>(x)];
    const Along& down = down_[static_cast<std::size_t>(y)];
    const std::size_t pixel = view_.region.Index(x, y);
    const float range_m = RangeM(pixel);
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const double weight = (dx == 0 ? 1.0 - across.share : across.share) *
                              (dy == 0 ? 1.0 - down.share : down.share);
        if (!(weight > 0.0)) continue;
        const int row = down.first + dy;
        int column = across.first + dx;
        if (row < 0 || row >= rows_) continue;
        if (wraps_x_) column = (column + columns_) % columns_;
        if (column < 0 || column >= columns_) continue;
        if (const Plane* plane = Find(pixel, range_m, planes_[Block(column, row)])) {
          visit(plane->receiver, weight);
        }
      }
    }
  }

 private:
  // What a block shows of one plane: its receiver stands at `pixel`.
  struct Plane {
    std::size_t pixel = 0;
    std::uint32_t receiver = 0;
  };

  // Along one side of the picture: a pixel lies between the middles of block `first` and the next,
  // by `share` of the way.
  struct Along {
    int first = 0;
    double share = 0.0;
  };
  static std::vector<Along> AlongSide(int pixels, int block_px);

  // Memory of Collect.
  struct Scratch {
    struct Member {
      glm::ivec2 pixel;
      std::size_t plane;
    };
    struct Middle {
      glm::dvec2 sum{0.0};
      int count = 0;
      double nearest = 0.0;
    };
    std::vector<Member> members;
    std::vector<Middle> middles;
  };

  std::size_t Block(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  // Distance from the eye of the view.
  float RangeM(std::size_t pixel) const {
    return glm::distance(view_.position_world_m.pixels[pixel], origin_m_);
  }
  // The pixel's plane among those of a block; null where it is none of them.
  const Plane* Find(std::size_t pixel, float range_m, const std::vector<Plane>& block) const {
    for (const Plane& plane : block) {
      if (SamePlane(view_.position_world_m.pixels[pixel],
                    view_.normal_world.pixels[pixel],
                    view_.position_world_m.pixels[plane.pixel],
                    view_.normal_world.pixels[plane.pixel],
                    range_m)) {
        return &plane;
      }
    }
    return nullptr;
  }
  void Collect(int column, int row, const Gray8Image* candidates, Scratch& scratch);

  const SurfaceView& view_;
  glm::vec3 origin_m_;
  int block_px_;
  bool wraps_x_;
  int columns_;
  int rows_;
  std::vector<Along> across_;               // Per column,
  std::vector<Along> down_;                 // and per row of the picture.
  std::vector<std::vector<Plane>> planes_;  // Per block, row-major.
  std::vector<Receiver> receivers_;
  std::vector<std::size_t> receiver_pixels_;
};

}  // namespace pleinair
