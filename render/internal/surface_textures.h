// A SurfaceView on the device: what the composite knows of the real pixels.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "render/internal/screen_extent.h"
#include "render/internal/streamed_texture.h"
#include "scene/image.h"
#include "scene/state_id.h"
#include "scene/surface_view.h"

namespace pleinair {

// Uploads what has changed, by the view's states, and only the part that is asked for. Elsewhere
// the textures are undefined.
class SurfaceTextures {
 public:
  // `rect` lies in the picture and is not empty.
  void Update(const SurfaceView& view, const PixelRect& rect);
  // This frame's picture; `clipped` may be empty: nothing is.
  void UpdateCamera(const RgbImage& radiance, const Gray8Image& clipped, const PixelRect& rect);

  // RGBA32F.
  GLuint Camera() const { return camera_.Name(); }             // Alpha: 1 where it clipped.
  GLuint Albedo() const { return albedo_.Name(); }             // Alpha: 1 where it was measured.
  GLuint Normal() const { return normal_.Name(); }             // World.
  GLuint SkyResponse() const { return sky_response_.Name(); }  // An array, a layer a shape.
  GLuint SunBounce() const { return sun_bounce_.Name(); }
  // RG32F: sun visibility, distance to the nearest edge in pixels.
  GLuint SunVisibility() const { return sun_visibility_.Name(); }

 private:
  struct Size {
    int width = 0;
    int height = 0;
    int sky_shapes = 0;
    bool operator==(const Size&) const = default;
  };
  // The part of some images that is on the device, and the state that it was uploaded from.
  struct Uploaded {
    StateId state;
    PixelRect rect;

    // The part that has to be uploaded; empty where `wanted` is there.
    PixelRect Missing(const Uploaded& wanted) const;
  };

  void Resize(const Size& size);

  Size size_;
  Size camera_size_;
  Uploaded geometry_;
  Uploaded sky_;
  Uploaded sun_;
  StreamedTexture<glm::vec4> camera_;
  StreamedTexture<glm::vec4> albedo_;
  StreamedTexture<glm::vec4> normal_;
  StreamedTexture<glm::vec4> sky_response_{GL_TEXTURE_2D_ARRAY};
  StreamedTexture<glm::vec4> sun_bounce_;
  StreamedTexture<glm::vec2> sun_visibility_;
};

}  // namespace pleinair
