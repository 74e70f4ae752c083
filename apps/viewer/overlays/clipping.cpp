#include "apps/viewer/overlay.h"

namespace pleinair {

Rgba8Image DrawClipping(const OverlayInput& input) {
  constexpr glm::u8vec4 kClippedColour{235, 30, 30, 255};
  constexpr glm::u8vec4 kDarkColour{40, 80, 235, 255};
  constexpr glm::u8vec4 kMaskedColour{120, 120, 120, 200};
  const Gray8Image& unusable = input.frame.unusable;
  Rgba8Image picture(unusable.width, unusable.height, kNoColour);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const std::uint8_t flags = unusable.pixels[i];
    const bool is_clipped = (flags & (kClipped[0] | kClipped[1] | kClipped[2])) != 0;
    if (is_clipped || (i < input.frame.clipped.pixels.size() && input.frame.clipped.pixels[i])) {
      picture.pixels[i] = kClippedColour;
    } else if ((flags & kNearBlack) != 0) {
      picture.pixels[i] = kDarkColour;
    } else if (flags != 0) {
      picture.pixels[i] = kMaskedColour;
    }
  }
  return picture;
}

}  // namespace pleinair
