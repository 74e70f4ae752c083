// Where the samples of pixels lie. No OpenGL here.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

namespace pleinair {

// Samples are drawn as a picture of their own, turned by atan(turn / side) against that of the
// pixels and side^2 + turn^2 times as fine. Sample (s, t) of it lies at pixel M^-1 (s, t), M =
// [side turn; -turn side]. M is an integer matrix, so all pixels have their samples at the same
// places. With a turn of 1 no two samples of a pixel share a row or column. So an edge that is
// nearly upright or level passes them one by one; in a grid along the pixels it passes `side` at
// once (after the rotated grids of multisampling hardware).
//
// Coordinates are those of windows: from corners, of the rectangle of pixels that is drawn.
class SampleLattice {
 public:
  static constexpr int kMostSide = 8;
  static constexpr int kMostPerPixel = kMostSide * kMostSide + 1;

  SampleLattice() : SampleLattice(2, {0, 0}) {}
  // Turned where that is not too wasteful: the corners of the samples' picture lie outside the
  // pixels', and of a long strip they are most of it.
  // Throws std::invalid_argument for a side that is odd, of which some samples would lie on pixels'
  // edges, or not in 2 .. kMostSide.
  SampleLattice(int side, const glm::ivec2& pixels);

  int Side() const { return side_; }
  int Turn() const { return turn_; }  // 0 or 1.
  int PerPixel() const { return side_ * side_ + turn_; }
  const glm::ivec2& Pixels() const { return pixels_; }
  // Size of the samples' picture.
  glm::ivec2 Size() const;
  // The samples of a pixel: that of the pixel, and what to add for each.
  glm::ivec2 Of(const glm::ivec2& pixel) const;
  const std::vector<glm::ivec2>& Offsets() const { return offsets_; }
  // Transforms clip coordinates of the pixels' picture to those of the samples'.
  glm::dmat4 ClipFromPixelsClip() const;

 private:
  int side_;
  glm::ivec2 pixels_;
  int turn_ = 1;
  std::vector<glm::ivec2> offsets_;
};

}  // namespace pleinair
