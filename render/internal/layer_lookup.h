// Where each pixel of a distorted picture lies in the undistorted layers.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"
#include "scene/camera.h"

namespace pleinair {

// The camera's own pixels are never resampled. Instead the layers are looked up, at the place that
// this texture has for each pixel.
class LayerLookup {
 public:
  // Makes the texture again where the camera is another one.
  void Update(const CameraIntrinsics& camera);

  // The layers' camera: the smallest undistorted one that covers the picture.
  const CameraIntrinsics& Undistorted() const { return undistorted_; }
  bool IsIdentity() const { return !camera_.HasDistortion(); }
  // RG32F, window coordinates in the layers; far outside where no direction leads to a pixel. Only
  // where not IsIdentity().
  GLuint Texture() const { return texture_.Name(); }
  // The same for one pixel.
  const glm::vec2& PlaceOf(int x, int y) const {
    return lookup_[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width_px) +
                   static_cast<std::size_t>(x)];
  }

  // The camera's pixels that look into `rect` of the layers.
  PixelRect CameraRectOf(const PixelRect& rect) const;

 private:
  CameraIntrinsics camera_;
  CameraIntrinsics undistorted_;
  std::vector<glm::vec2> lookup_;
  GlObject texture_;
};

}  // namespace pleinair
