#include "scene/surface_view.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace pleinair {

glm::vec3 SunResponse(const SurfaceView& view,
                      std::size_t pixel,
                      const glm::dvec3& sun_direction_enu) {
  const double n_dot_l = glm::dot(glm::dvec3(view.normal_world.pixels[pixel]), sun_direction_enu);
  const float direct =
      view.sun_visibility.pixels[pixel] * static_cast<float>(std::max(n_dot_l, 0.0));
  return glm::vec3(direct) + view.sun_bounce.pixels[pixel];
}

}  // namespace pleinair
