#include "render/internal/sample_lattice.h"

namespace pleinair {

SampleLattice::SampleLattice(int side, const glm::ivec2& pixels) : side_(side), pixels_(pixels) {
  // Those whose middles lie in pixel (0, 0). None lies on its edge: there are halves in them.
  const int count = PerPixel();
  for (int t = -1; t <= side; ++t) {
    for (int s = 0; s <= side; ++s) {
      const glm::ivec2 twice_place(side * (2 * s + 1) - (2 * t + 1),
                                   2 * s + 1 + side * (2 * t + 1));
      const bool is_inside = twice_place.x > 0 && twice_place.y > 0 && twice_place.x < 2 * count &&
                             twice_place.y < 2 * count;
      if (is_inside) offsets_.emplace_back(s, t);
    }
  }
}

glm::ivec2 SampleLattice::Size() const {
  return {side_ * pixels_.x + pixels_.y, pixels_.x + side_ * pixels_.y};
}

glm::ivec2 SampleLattice::Of(const glm::ivec2& pixel) const {
  return {side_ * pixel.x + pixel.y, side_ * pixel.y - pixel.x + pixels_.x};
}

glm::dmat4 SampleLattice::ClipFromPixelsClip() const {
  const glm::dvec2 size(Size());
  const glm::dvec2 pixels(pixels_);
  glm::dmat4 clip(1.0);
  clip[0] = {side_ * pixels.x / size.x, -pixels.x / size.y, 0.0, 0.0};
  clip[1] = {pixels.y / size.x, side_ * pixels.y / size.y, 0.0, 0.0};
  return clip;
}

}  // namespace pleinair
