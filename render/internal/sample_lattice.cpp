#include "render/internal/sample_lattice.h"

#include <cstdint>
#include <stdexcept>
#include <string>

namespace pleinair {
namespace {

// Samples drawn for each that counts. A square has 1.5 times as many, a rectangle six times as long
// as wide 2.5.
constexpr double kMostWaste = 2.5;

}  // namespace

SampleLattice::SampleLattice(int side, const glm::ivec2& pixels) : side_(side), pixels_(pixels) {
  if (side < 2 || side > kMostSide || side % 2 != 0) {
    throw std::invalid_argument(std::string("sample lattice: side is ") + std::to_string(side) +
                                ": expected 2, 4, 6 or 8");
  }
  const glm::dvec2 turned_size(Size());
  const double used = static_cast<double>(PerPixel()) * pixels_.x * pixels_.y;
  if (turned_size.x * turned_size.y > kMostWaste * used) turn_ = 0;
  // Those whose middles lie in pixel (0, 0). None lies on its edge: there are halves in them.
  for (int t = -turn_; t <= side; ++t) {
    for (int s = 0; s <= side; ++s) {
      const glm::ivec2 twice(2 * s + 1, 2 * t + 1);
      const glm::ivec2 twice_place(side * twice.x - turn_ * twice.y,
                                   turn_ * twice.x + side * twice.y);
      const bool is_inside = twice_place.x > 0 && twice_place.y > 0 &&
                             twice_place.x < 2 * PerPixel() && twice_place.y < 2 * PerPixel();
      if (is_inside) offsets_.emplace_back(s, t);
    }
  }
}

glm::ivec2 SampleLattice::Size() const {
  return {side_ * pixels_.x + turn_ * pixels_.y, turn_ * pixels_.x + side_ * pixels_.y};
}

glm::ivec2 SampleLattice::Of(const glm::ivec2& pixel) const {
  return {side_ * pixel.x + turn_ * pixel.y, side_ * pixel.y - turn_ * pixel.x + turn_ * pixels_.x};
}

glm::dmat4 SampleLattice::ClipFromPixelsClip() const {
  const glm::dvec2 size(Size());
  const glm::dvec2 pixels(pixels_);
  glm::dmat4 clip(1.0);
  clip[0] = {side_ * pixels.x / size.x, -turn_ * pixels.x / size.y, 0.0, 0.0};
  clip[1] = {turn_ * pixels.y / size.x, side_ * pixels.y / size.y, 0.0, 0.0};
  return clip;
}

}  // namespace pleinair
