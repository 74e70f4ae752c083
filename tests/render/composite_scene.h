// A small real scene with its camera picture made from the lighting model: ground, a wall, sky.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "ray_cast_reference.h"
#include "render/compositor.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair::test {

// For tests of both ways to composite.
inline constexpr CompositeBy kByBoth[] = {CompositeBy::kDevice, CompositeBy::kProcessor};
inline std::string NameOfCompositeBy(const testing::TestParamInfo<CompositeBy>& info) {
  return info.param == CompositeBy::kDevice ? "Device" : "Processor";
}

class CompositeScene {
 public:
  explicit CompositeScene(const glm::dvec3& to_sun, int width_px = 240, int height_px = 180);

  const pleinair::Camera& Camera() const { return view.camera; }
  // Another lens in front of the same camera; the view and the picture are made again.
  void SetIntrinsics(const CameraIntrinsics& intrinsics);
  // Fills `radiance` with the model's.
  void RenderCameraFromModel();
  // albedo / pi (sky C + sun (visibility n.l + bounce)).
  glm::dvec3 ModelRadiance(std::size_t pixel, double sun_visibility) const;
  CompositeInput Input(std::span<const std::vector<glm::vec3>> vertex_irradiance) const;

  Mesh phantom;
  SurfaceView view;
  Lighting lighting;
  RgbImage radiance;
  Gray8Image clipped;

 private:
  void MakeView();
};

struct LightOnObject {
  const Lighting& lighting;
  double irradiance = 0.0;  // Of everything but the sun.
  double sun = 0.0;         // 1 in the sun, 0 in shadow.
};

// What ObjectLayerPass's comment says, in double: the object's radiance at a visible point, its
// shading normal interpolated.
glm::dvec3 ShadedObject(const Mesh& mesh,
                        const VisiblePoint& point,
                        const pleinair::Camera& camera,
                        const LightOnObject& light);

}  // namespace pleinair::test
