// Shade on virtual objects that is visible in the picture but that the mesh does not cast: of
// trees, eaves, or a house behind the camera.
#pragma once

#include <cstdint>
#include <map>

#include <glm/vec2.hpp>

#include "objects/shadow_places.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "scene/image.h"
#include "scene/sun_shares.h"

namespace pleinair {

// The search for one set of places, in frame after frame.
//
// Returns the share of the sun that remains on the objects, 0..1, from the pixels where the
// objects' shadows fall. A pixel may have the radiance of its surface in shade (real_sun.h) though
// the mesh has it in the sun. Then something real hides the sun there, and so on the object. A
// pixel that is too dark for that shows something other than the surface, and is no evidence.
//
// Most of the pixels around a pixel decide, twice, as a few dark or bright ones are stains: many
// places of an object can have their shadows in one of them. The share is a trimmed mean over
// neighbours on the object; this sets the sharpness of shadows there. Places whose shadow is not in
// the picture have the mean of the nearest ones on the same object.
//
// Shape    as the places; 1 beside the objects, but for their next pixels. Null where no shade is
//          seen.
// Keeps    what is returned: until the next call.
// Not      distinguished from shade: a thing between object and surface that shades the surface
//          alone.
class SeenShade {
 public:
  enum class Finding : std::uint8_t { kUnknown, kInShade, kInSun };
  static constexpr int kReachPx = 10;  // Around the places' shadows, pixels are looked at.

  SeenShade() = default;
  // `picture_px` is the size of the picture in which the shadows fall.
  SeenShade(ShadowPlaces places, const glm::ivec2& picture_px);

  const GrayImage* SunLeft(const EffectFrame& frame);

 private:
  // The last pixel is inside.
  struct PixelBox {
    glm::ivec2 lower{0};
    glm::ivec2 upper{0};

    glm::ivec2 Size() const { return upper - lower + 1; }
  };

  glm::ivec2 InPicture(std::int32_t pixel) const;
  void FindPixels(const EffectFrame& frame);
  // Fills left_ for one object.
  void TakeMeans(std::uint32_t object, const PixelBox& box);
  // A pixel's values are also looked up from beside it.
  void FillBeside(const PixelBox& box);

  ShadowPlaces places_;
  int picture_width_px_ = 0;
  std::map<std::uint32_t, PixelBox> boxes_;  // The box of each object.
  Image<Finding> found_;                     // What each pixel's shadow shows.
  PixelBox shadows_;                         // In the picture, with the pixels around them.
  Image<std::uint8_t> is_around_shadow_;     // In that box.
  Image<Finding> found_in_picture_;          // In that box.
  GrayImage left_;
};

// The part `left` of the objects' visible share of the sun, in `result`.
void TakeSun(const ObjectSunShare& share, const GrayImage& left, ObjectSunShare& result);

}  // namespace pleinair
