// The part of a view that is looked at: other pixels need not be made.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/pixel_rect.h"

namespace pleinair {

// Places on the surfaces of a scene. Pixels are looked at that show one of them.
struct LookedAtPlaces {
  // Whether one of them is within `reach_m` of a point on a triangle's side. Empty: there is none.
  // Called from several threads.
  std::function<bool(std::int32_t side, const glm::vec3& point_m, float reach_m)> any_near;
  int margin_px = 0;  // Pixels around those that are looked at, too.
};

struct ViewPart {
  std::vector<PixelRect> rects;  // May reach beyond the picture.
  LookedAtPlaces places;
};

}  // namespace pleinair
