// Where the samples of pixels lie. No OpenGL here.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

namespace pleinair {

// Samples are drawn as a picture of their own, turned by atan(1 / side) against that of the pixels
// and side^2 + 1 times as fine: sample (s, t) of it lies at pixel M^-1 (s, t), M = [side 1; -1
// side]. M is whole, so all pixels have their samples at the same places; no two of a pixel's are
// in one row or column of it, so that an edge that is nearly upright or level passes them one by
// one, where a grid along the pixels has it pass `side` at once (after the rotated grids of
// multisampling hardware).
//
// Coordinates are those of windows: from corners, of the rectangle of pixels that is drawn.
class SampleLattice {
 public:
  SampleLattice() : SampleLattice(2, {0, 0}) {}
  // `side` is even, 2 or more: of an odd one some samples would lie on pixels' edges.
  SampleLattice(int side, const glm::ivec2& pixels);

  int Side() const { return side_; }
  int PerPixel() const { return side_ * side_ + 1; }
  const glm::ivec2& Pixels() const { return pixels_; }
  // Of the samples' picture, whose corners are outside the pixels'.
  glm::ivec2 Size() const;
  // The samples of a pixel: that of the pixel, and what to add for each.
  glm::ivec2 Of(const glm::ivec2& pixel) const;
  const std::vector<glm::ivec2>& Offsets() const { return offsets_; }
  // From clip coordinates of the pixels' picture to those of the samples'.
  glm::dmat4 ClipFromPixelsClip() const;

 private:
  int side_;
  glm::ivec2 pixels_;
  std::vector<glm::ivec2> offsets_;
};

}  // namespace pleinair
