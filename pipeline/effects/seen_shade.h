// Shade on virtual objects that is visible in the picture but that the mesh does not cast: of
// trees, eaves, or a house behind the camera.
#pragma once

#include <cstdint>
#include <map>

#include <glm/vec2.hpp>

#include "objects/shadow_places.h"
#include "pipeline/effects/frame_effect.h"
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
// The share is a trimmed mean over neighbours, as single dark pixels are stains; this sets the
// sharpness of shadows on the object. Places whose shadow is not in the picture have the mean of
// the nearest ones on the same object.
//
// Shape    as the places; 1 beside the objects. Null where no shade is seen.
// Keeps    what is returned: until the next call.
// Not      distinguished from shade: a thing between object and surface that shades the surface
//          alone.
class SeenShade {
 public:
  SeenShade() = default;
  explicit SeenShade(ShadowPlaces places);

  const GrayImage* SunLeft(const EffectFrame& frame);

 private:
  // What was found of each pixel's shadow.
  enum class Finding : std::uint8_t { kUnknown, kInShade, kInSun };
  // The last pixel is inside.
  struct PixelBox {
    glm::ivec2 lower{0};
    glm::ivec2 upper{0};
  };

  // Fills left_ for one object.
  void TakeMeans(std::uint32_t object, const PixelBox& box);

  ShadowPlaces places_;
  std::map<std::uint32_t, PixelBox> boxes_;  // Of each object.
  Image<Finding> found_;
  GrayImage left_;
};

// The part `left` of the objects' visible share of the sun, in `result`.
void TakeSun(const ObjectSunShare& share, const GrayImage& left, ObjectSunShare& result);

}  // namespace pleinair
