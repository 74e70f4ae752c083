// A SurfaceView on the device: what the composite knows of the real pixels.
#pragma once

#include <cstdint>

#include "render/internal/gl_object.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Uploads what has changed, by the view's versions.
class SurfaceTextures {
 public:
  void Update(const SurfaceView& view);
  // This frame's picture; `clipped` may be empty: nothing is.
  void UpdateCamera(const RgbImage& radiance, const Gray8Image& clipped);

  GLuint Camera() const { return camera_.Name(); }    // RGB32F.
  GLuint Clipped() const { return clipped_.Name(); }  // R8.
  // RGBA32F: albedo, and 1 where it was measured.
  GLuint Albedo() const { return albedo_.Name(); }
  GLuint Normal() const { return normal_.Name(); }             // RGB32F, world.
  GLuint SkyResponse() const { return sky_response_.Name(); }  // RGB32F array, a layer a shape.
  GLuint SunBounce() const { return sun_bounce_.Name(); }      // RGB32F.
  // RG32F: sun visibility, distance to the nearest edge in pixels.
  GLuint SunVisibility() const { return sun_visibility_.Name(); }

 private:
  struct Size {
    int width = 0;
    int height = 0;
    int sky_shapes = 0;
    bool operator==(const Size&) const = default;
  };

  Size size_;
  Size camera_size_;
  // By versions alone, two views without versions would look equal.
  const void* geometry_data_ = nullptr;
  const void* sky_data_ = nullptr;
  const void* sun_data_ = nullptr;
  std::uint64_t geometry_version_ = 0;
  std::uint64_t sky_version_ = 0;
  std::uint64_t sun_version_ = 0;
  GlObject camera_;
  GlObject clipped_;
  GlObject albedo_;
  GlObject normal_;
  GlObject sky_response_;
  GlObject sun_bounce_;
  GlObject sun_visibility_;
};

}  // namespace pleinair
