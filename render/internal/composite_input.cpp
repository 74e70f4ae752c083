#include "render/internal/composite_input.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "render/internal/blur_kernel.h"
#include "render/internal/composite_pass.h"

namespace pleinair {
namespace {

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

template <typename Pixel>
void RequireSize(const Image<Pixel>& image, const SurfaceView& view, const char* name) {
  if (image.width == view.Width() && image.height == view.Height() &&
      image.pixels.size() == view.region.pixels.size()) {
    return;
  }
  throw std::invalid_argument(std::string(name) + " is " + SizeText(image.width, image.height) +
                              ", expected " + SizeText(view.Width(), view.Height()) +
                              ", the size of view.region");
}

template <typename Pixel>
void RequireInside(const Image<Pixel>& image,
                   const glm::ivec2& lower,
                   const SurfaceView& view,
                   const char* name) {
  if (lower.x >= 0 && lower.y >= 0 && lower.x + image.width <= view.Width() &&
      lower.y + image.height <= view.Height()) {
    return;
  }
  throw std::invalid_argument(std::string(name) + " of " + SizeText(image.width, image.height) +
                              " at (" + std::to_string(lower.x) + ", " + std::to_string(lower.y) +
                              "): expected inside the picture, " +
                              SizeText(view.Width(), view.Height()));
}

void RequireMotion(const MotionInPicture& input, std::size_t objects) {
  if (input.motion.objects.size() != objects) {
    throw std::invalid_argument(
        "motion.objects has " + std::to_string(input.motion.objects.size()) +
        " entries, expected " + std::to_string(objects) + ", one an object");
  }
  const Image<std::int32_t>& shown = input.objects.object;
  const GrayImage& depth = input.objects.depth_m;
  if (shown.width != depth.width || shown.height != depth.height) {
    throw std::invalid_argument("motion: depths of " + SizeText(depth.width, depth.height) +
                                ", expected " + SizeText(shown.width, shown.height) +
                                ", the size of the objects' numbers");
  }
  for (const std::int32_t object : shown.pixels) {
    const bool is_known = object == ObjectDepths::kNone ||
                          (object >= 0 && static_cast<std::size_t>(object) < objects);
    if (!is_known) {
      throw std::invalid_argument("motion: object " + std::to_string(object) + ", expected 0 to " +
                                  std::to_string(objects - 1) + " or none");
    }
  }
}

}  // namespace

void ValidateCamera(const Camera& camera) {
  const CameraIntrinsics& intrinsics = camera.intrinsics;
  if (intrinsics.width_px < 1 || intrinsics.height_px < 1) {
    throw std::invalid_argument("camera picture is " +
                                SizeText(intrinsics.width_px, intrinsics.height_px) +
                                ", expected at least 1x1");
  }
  if (!(intrinsics.fx_px > 0.0) || !(intrinsics.fy_px > 0.0)) {
    throw std::invalid_argument("camera fx_px " + std::to_string(intrinsics.fx_px) + ", fy_px " +
                                std::to_string(intrinsics.fy_px) + ": expected both above 0");
  }
}

glm::dvec3 ValidatedDirection(const glm::dvec3& direction) {
  const double length = glm::length(direction);
  if (!(std::abs(length - 1.0) <= 1e-3)) {
    throw std::invalid_argument("sun direction has length " + std::to_string(length) +
                                ", expected a unit vector");
  }
  return direction / length;
}

void ValidateInput(const CompositeInput& input, std::span<const VirtualObject> objects) {
  const SurfaceView& view = input.view;
  ValidateCamera(view.camera);
  if (view.camera.intrinsics.width_px != view.Width() ||
      view.camera.intrinsics.height_px != view.Height()) {
    throw std::invalid_argument(
        "view.region is " + SizeText(view.Width(), view.Height()) + ", expected the camera's " +
        SizeText(view.camera.intrinsics.width_px, view.camera.intrinsics.height_px));
  }
  RequireSize(input.camera_radiance, view, "camera_radiance");
  if (!input.clipped.Empty()) RequireSize(input.clipped, view, "clipped");
  RequireSize(view.albedo_rgb, view, "view.albedo_rgb");
  RequireSize(view.albedo_measured, view, "view.albedo_measured");
  RequireSize(view.normal_world, view, "view.normal_world");
  RequireSize(view.sun_visibility, view, "view.sun_visibility");
  RequireSize(view.sun_bounce, view, "view.sun_bounce");
  RequireSize(view.edge_distance_px, view, "view.edge_distance_px");
  for (const Image<glm::vec3>& response : view.sky_response) {
    RequireSize(response, view, "view.sky_response");
  }
  if (!(input.camera_blur_px >= 0.0f && input.camera_blur_px <= BlurKernel::kMostSigmaPx)) {
    throw std::invalid_argument("camera_blur_px is " + std::to_string(input.camera_blur_px) +
                                ": expected 0 to 8 pixels");
  }
  if (view.sky_response.size() != input.lighting.sky.size()) {
    throw std::invalid_argument("lighting.sky has " + std::to_string(input.lighting.sky.size()) +
                                " shapes, view.sky_response " +
                                std::to_string(view.sky_response.size()) +
                                ": expected the same number");
  }
  if (view.sky_response.size() > static_cast<std::size_t>(CompositePass::kMaxSkyShapes)) {
    throw std::invalid_argument(
        "view.sky_response has " + std::to_string(view.sky_response.size()) +
        " shapes, expected at most " + std::to_string(CompositePass::kMaxSkyShapes));
  }
  if (input.irradiance_change != nullptr) {
    const IrradianceChange& change = *input.irradiance_change;
    RequireInside(change.irradiance_rgb, {change.x_px, change.y_px}, view, "irradiance_change");
  }
  if (input.sun_shares != nullptr) {
    const RealSunShare& real = input.sun_shares->real;
    RequireInside(real.hidden, {real.x_px, real.y_px}, view, "sun_shares.real");
  }
  if (input.motion != nullptr) RequireMotion(*input.motion, objects.size());
  if (!input.effects.probe_shading) return;
  if (input.vertex_irradiance.size() != objects.size()) {
    throw std::invalid_argument(
        "vertex_irradiance has " + std::to_string(input.vertex_irradiance.size()) +
        " entries, expected " + std::to_string(objects.size()) + ", one an object");
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (input.vertex_irradiance[i].size() != objects[i].mesh.positions_m.size()) {
      throw std::invalid_argument(
          "vertex_irradiance[" + std::to_string(i) + "] has " +
          std::to_string(input.vertex_irradiance[i].size()) + " entries, expected " +
          std::to_string(objects[i].mesh.positions_m.size()) + ", one a vertex of that object");
    }
  }
}

}  // namespace pleinair
