// A camera's image points as rays into the world, lens distortion included.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "relight/transport/view_rays.h"
#include "scene/camera.h"
#include "scene/image.h"

namespace pleinair {

// Unit directions through the pixels' centres in the camera's frame, which stay while it moves;
// zero where no light comes from.
std::shared_ptr<const Image<glm::vec3>> DirectionsInCamera(const CameraIntrinsics& intrinsics);

class CameraPixels {
 public:
  explicit CameraPixels(const Camera& camera)
      : intrinsics_(camera.intrinsics),
        world_from_camera_(glm::transpose(glm::dmat3(camera.camera_from_world))),
        origin_m_(camera.CentreWorldM()) {}

  const glm::dvec3& OriginM() const { return origin_m_; }

  // Unit direction through an image point.
  std::optional<glm::dvec3> Direction(const glm::dvec2& pixel) const {
    const std::optional<glm::dvec3> direction = DirectionFromPixel(intrinsics_, pixel);
    if (!direction) return std::nullopt;
    return glm::normalize(world_from_camera_ * *direction);
  }

  // Where the ray through an image point meets a plane; none where it runs along or away from it.
  std::optional<glm::vec3> OnPlane(const glm::dvec2& pixel,
                                   const glm::vec3& position_m,
                                   const glm::vec3& normal) const {
    const std::optional<glm::dvec3> direction = Direction(pixel);
    if (!direction) return std::nullopt;
    const double approach = glm::dot(*direction, glm::dvec3(normal));
    const double height_m = glm::dot(glm::dvec3(position_m) - origin_m_, glm::dvec3(normal));
    if (!(approach * height_m > 0.0)) return std::nullopt;
    return glm::vec3(origin_m_ + height_m / approach * *direction);
  }

  // `in_camera` is DirectionsInCamera of this camera's intrinsics.
  ViewRays Rays(std::shared_ptr<const Image<glm::vec3>> in_camera) const {
    return {.width = intrinsics_.width_px,
            .height = intrinsics_.height_px,
            .wraps_x = false,
            .origin_m = glm::vec3(origin_m_),
            .world_from_view = glm::mat3(world_from_camera_),
            .directions = std::move(in_camera)};
  }

 private:
  CameraIntrinsics intrinsics_;
  glm::dmat3 world_from_camera_;
  glm::dvec3 origin_m_;
};

}  // namespace pleinair
