#include "calib/shown_picture.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "calib/response.h"
#include "scene/image_io.h"

namespace pleinair {

Rgb8Image Shown(RgbImage radiance) {
  RepairRadiance(radiance);
  std::vector<float> light;
  light.reserve(radiance.pixels.size());
  for (const glm::vec3& pixel : radiance.pixels) {
    light.push_back(std::max({pixel.x, pixel.y, pixel.z}));
  }
  const auto white = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 99 / 100);
  std::nth_element(light.begin(), white, light.end());
  return CodesFromRadiance(radiance, ResponseCurve::Srgb(), *white > 0.0f ? 1.0 / *white : 1.0);
}

}  // namespace pleinair
