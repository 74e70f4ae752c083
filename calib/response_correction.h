// What a camera makes of light beyond its stated response, as its pictures show.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/response.h"
#include "scene/image.h"

namespace pleinair {

// The circle through a picture's corners, pixels from its upper left corner: a pixel's centre is at
// its coordinates plus a half. A lens loses light towards the circle.
struct LensCircle {
  glm::dvec2 centre_px{0.0};
  double radius_px = 1.0;  // > 0.

  static LensCircle Of(int width_px, int height_px);
  // 0 at the centre, 1 in the corners; grows with the square of the distance.
  double ShareOfCorner(const glm::dvec2& place_px) const;
};

// From radiance to what is recorded as such, in one unit:
//   seen = (light / unit + veil) (1 - vignetting ShareOfCorner),
//   recorded = white (Saturated(seen) / white)^(1 + exponent),
// where Saturated makes each channel's distance from the mean of the three larger, by the share
// `saturation`. Shadows and objects are computed with light, and recorded as the camera would have
// recorded them.
struct ResponseCorrection {
  double white_radiance = 1.0;  // 1 over the exposure; 1 where that is unknown.
  // Where the exposure is unknown: so that light as bright as what the picture shows is recorded as
  // it is; > 0.
  glm::dvec3 unit_rgb{1.0};
  glm::dvec3 veil_rgb{0.0};  // Added everywhere: haze, flare, a wrong black level.
  double vignetting = 0.0;   // Share of light that is lost in the corners; < 1.
  double saturation = 0.0;   // > -1.
  double exponent = 0.0;     // > -1.

  bool IsNone() const;
};

// Each channel's distance from the mean of the three, larger by the share `saturation`.
glm::dvec3 Saturated(const glm::dvec3& rgb, double saturation);
// The inverse.
glm::dvec3 Desaturated(const glm::dvec3& rgb, double saturation);

// Returns the light of a pixel's recorded radiance; 0 where that is darker than the veil.
glm::dvec3 LightOf(const glm::dvec3& recorded,
                   const ResponseCorrection& correction,
                   double share_of_corner);
// The same of a picture, all pixels. `light` keeps its memory where it has the picture's size: new
// memory takes as long as the work.
void LightOf(const Rgb8Image& codes,
             const ResponseCurve& response,
             const ResponseCorrection& correction,
             RgbImage& light);

// The inverse, for a pixel.
glm::vec3 Recorded(const glm::vec3& light,
                   const ResponseCorrection& correction,
                   double share_of_corner);

}  // namespace pleinair
