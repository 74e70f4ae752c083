// Penumbrae: the share of the sun's disc that is seen past real and virtual casters together, where
// objects change it or stand in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/object_view.h"
#include "relight/transport/patch_scene.h"
#include "scene/lighting.h"
#include "scene/sun_shares.h"
#include "scene/surface_view.h"

namespace pleinair {

class CameraPixels;  // relight/transport/camera_pixels.h
class DiscPoints;    // internal/disc_points.h

struct SoftSunOptions {
  // Points of the disc, each cast to from another place in the pixel, for a pixel near an edge of
  // shadow; on objects its samples have a quarter of them each. The others are shaded by 4
  // (objects) or 5 points alone. Converged: as many as wished. At least 4.
  int disc_samples = 32;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Accuracy  Steps of 1 / disc_samples. A caster that leaves less than a pixel of shadow may be
//           missed.
// Threads   The results do not depend on their number.
class SoftSun {
 public:
  // `objects` has a group an object. Keeps references to `real` and `objects`.
  SoftSun(const RayCaster& real, const PatchScene& objects, const SoftSunOptions& options = {});

  // Pixels that face the sun and from which an object may stand before some of the disc, by the
  // objects' boxes alone, in ascending order: only these can lose sun.
  std::vector<std::uint32_t> PixelsNearShadow(const SurfaceView& view,
                                              const DirectionalLight& sun) const;
  // Whether such a place is within `reach_m` of a point, whichever way surfaces face. Holds a copy
  // of what it needs.
  std::function<bool(const glm::vec3& point_m, float reach_m)> NearShadow(
      const DirectionalLight& sun) const;
  // Which of `pixels` OnReal may darken: an object really hides some of five points of the disc
  // there or in a pixel beside it.
  // Shape  one entry each of `pixels`, 1 where it does.
  std::vector<std::uint8_t> MayLoseSun(const SurfaceView& view,
                                       const DirectionalLight& sun,
                                       std::span<const std::uint32_t> pixels) const;
  // The sun's share on the real surfaces of `view`, whose sun_visibility is that of `sun`.
  RealSunShare OnReal(const SurfaceView& view, const DirectionalLight& sun) const;
  // The sun's share on the objects, a mean over each sample's part of the pixel. Samples of faces
  // that are turned away from the sun, and beside an object, have their neighbours' mean: a
  // renderer may look finer, or place an edge a little differently.
  ObjectSunShare OnObjects(const ObjectView& view, const DirectionalLight& sun) const;

 private:
  // Box around an object, in coordinates of the sun's beam.
  struct Silhouette {
    glm::vec3 lower{0.0f};
    glm::vec3 upper{0.0f};
  };

  std::vector<Silhouette> SilhouettesFrom(const DiscPoints& disc) const;
  static bool IsNear(std::span<const Silhouette> silhouettes,
                     const DiscPoints& disc,
                     const glm::vec3& position_m,
                     float reach_m);
  std::vector<std::uint32_t> PixelsNearShadow(const SurfaceView& view,
                                              const DiscPoints& disc) const;
  float HiddenOver(const SurfaceView& view,
                   const CameraPixels& pixels,
                   std::size_t pixel,
                   const DiscPoints& disc) const;

  const RayCaster& real_;
  const PatchScene& objects_;
  SoftSunOptions options_;
};

}  // namespace pleinair
