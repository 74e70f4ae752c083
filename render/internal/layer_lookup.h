// Where each pixel of a distorted picture lies in the undistorted layers.
#pragma once

#include "render/internal/gl_object.h"
#include "scene/camera.h"

namespace pleinair {

// The camera's own pixels are never resampled: it is the layers that are looked up, at the place
// that this texture gives for each pixel.
class LayerLookup {
 public:
  // Makes the texture anew where the camera is another one.
  void Update(const CameraIntrinsics& camera);

  // The layers' camera: the smallest undistorted one that covers the picture.
  const CameraIntrinsics& Undistorted() const { return undistorted_; }
  bool IsIdentity() const { return !camera_.HasDistortion(); }
  // RG32F, window coordinates in the layers; far outside where no direction leads to a pixel. Only
  // where not IsIdentity().
  GLuint Texture() const { return texture_.Name(); }

 private:
  CameraIntrinsics camera_;
  CameraIntrinsics undistorted_;
  GlObject texture_;
};

}  // namespace pleinair
