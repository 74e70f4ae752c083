// Motion blur: means of objects and shadows over the exposure. No OpenGL here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "objects/virtual_object.h"
#include "render/internal/exposed_rows.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/pixel_paths.h"
#include "render/internal/processor_composite.h"
#include "render/internal/surface_paths.h"
#include "scene/exposure_motion.h"
#include "scene/irradiance_change.h"
#include "scene/sun_shares.h"
#include "scene/surface_view.h"

namespace pleinair {

// A pixel reads the picture of the frame's own instant at the places from which objects and shadows
// pass through it. These lie on a straight path for each pixel, between the places for the
// beginning and the end of its row's exposure, in steps of at most a pixel. Objects are as bright
// as at the frame's instant.
//
// Objects   move as their nearest points in the picture do. What a real surface, or an object with
//           another motion, hides at the frame's instant is not known. It is replaced by the mean
//           of the rest of that object that passes through the pixel.
// Shadows   move over the surfaces that pixels show (SurfacePaths).
// Cost      pixels times steps, independent of the meshes.
// Threads   The results do not depend on their number.
class MotionBlur {
 public:
  // All arguments outlive this. `objects` are where they are at the frame's instant.
  MotionBlur(const MotionInPicture& input,
             const SurfaceView& view,
             const LayerLookup& lookup,
             const glm::dvec3& to_sun,
             std::span<const VirtualObject> objects);

  // The objects' layer over the exposure; keeps the one of the frame's instant.
  LayerPart<glm::vec4> MoveObjects(LayerPart<glm::vec4> layer);

  // Shadows over the exposure, as far as objects do not cover them; after MoveObjects.
  RealSunShare Moved(const RealSunShare& share) const;
  IrradianceChange Moved(const IrradianceChange& change) const;

 private:
  // Objects with the same motion.
  struct Group {
    SteadyMotion motion;
    ExposedRows camera_from_camera;
    PixelRect rect;                    // Region of paths.
    std::vector<float> depth;          // Over rect: of the nearest of its pixels.
    std::vector<std::uint8_t> shows;   // Over rect: where it is the nearest object.
    std::vector<std::uint8_t> hidden;  // The same, behind a real surface.
    PixelPaths paths;
  };
  // The objects' layer at a pixel at one time.
  struct Tap {
    glm::vec4 value{0.0f};
    int unknown = 0;  // Group whose value is not known, and one; 0: none.
  };

  ExposedRows CameraFromCamera(const SteadyMotion& motion) const;
  double CameraRowOf(const glm::ivec2& layer_pixel) const;
  glm::dvec2 OffsetOf(const glm::dmat4& camera_from_camera, const glm::dvec2& at, double z) const;
  void FindReach(Group& group) const;
  void FindDepths(Group& group) const;
  void FindPaths(Group& group) const;
  void FindRealDepths();
  float RealDepthAt(const glm::ivec2& layer_pixel) const;
  Tap TapAt(const glm::ivec2& layer_pixel, float time) const;
  glm::vec4 OverExposure(const glm::ivec2& layer_pixel) const;

  template <typename Value>
  void MoveOnSurfaces(int& x_px,
                      int& y_px,
                      Image<Value>& image,
                      SurfacePaths::Carried carried) const;

  const MotionInPicture& input_;
  const ExposureMotion& motion_;
  const SurfaceView& view_;
  const LayerLookup& lookup_;
  glm::dmat4 world_from_camera_;
  SurfacePaths surfaces_;
  std::vector<Group> groups_;
  LayerPart<glm::vec4> layer_;
  PixelRect rect_;                 // The part of the picture that motion may change.
  std::vector<float> real_depth_;  // Over rect_: what is farther is behind a real surface.
  PixelPaths real_paths_;  // Paths of the real surfaces over rect_; empty where they do not move.
};

}  // namespace pleinair
