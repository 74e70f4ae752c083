#include "relight/transport/camera_pixels.h"

#include <tbb/parallel_for.h>

namespace pleinair {

std::shared_ptr<const Image<glm::vec3>> DirectionsInCamera(const CameraIntrinsics& intrinsics) {
  auto directions = std::make_shared<Image<glm::vec3>>(
      intrinsics.width_px, intrinsics.height_px, glm::vec3(0.0f));
  tbb::parallel_for(0, intrinsics.height_px, [&](int y) {
    for (int x = 0; x < intrinsics.width_px; ++x) {
      const auto direction =
          DirectionFromPixel(intrinsics, {static_cast<double>(x), static_cast<double>(y)});
      if (direction) directions->At(x, y) = glm::vec3(*direction);
    }
  });
  return directions;
}

}  // namespace pleinair
