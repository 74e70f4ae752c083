// Direct daylight by samples, and its shadows by virtual objects (grosch-2007, section 7.2): on the
// objects themselves and on real surfaces.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/daylight/window_sampling.h"
#include "relight/transport/transport.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct DaylightShadowOptions {
  // Side of a sample's shadow map, which spans the objects' bounding sphere; 1 to 1024. 0 casts a
  // ray in place of each look-up, which is what maps converge to.
  int map_size_px = 64;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Where the objects stand in the light of each sample: one small map a sample, side by side in one
// block of memory. Neither camera nor brightness matters to a map: it is drawn when its sample's
// direction is new.
//
// Method  A map holds, seen along the sample's direction, how far towards the light the objects
//         reach. A point behind that is in their shadow, whatever is in between; no offset is
//         needed, since a map holds no receiver. Only for such a point a ray tests whether the real
//         scene lets the light through, so nothing darkens twice.
// Unlike  grosch-2007, which draws a second map of the real geometry: a ray for the few points that
//         an object shades costs less than a map of the entire room, and has no stair steps.
class DaylightShadows {
 public:
  // Both casters outlive this; `sphere` contains all of `objects`. Throws std::invalid_argument for
  // bad options or sphere.
  DaylightShadows(const RayCaster& real,
                  const RayCaster& objects,
                  const BoundingSphere& sphere,
                  const DaylightShadowOptions& options = {});

  void SetSamples(std::span<const DaylightSample> samples);
  // How many maps the last SetSamples drew.
  std::size_t MapsDrawn() const { return maps_drawn_; }

  // Irradiance from all samples at points of the objects, past real scene and objects, by rays.
  std::vector<glm::vec3> OnObjects(std::span<const Receiver> receivers) const;
  // Irradiance that points of real surfaces have without the objects and lose to them.
  std::vector<glm::vec3> HiddenFrom(std::span<const Receiver> receivers) const;

 private:
  // A sample and the axes of its map.
  struct View {
    DaylightSample sample;
    glm::vec3 right{0.0f};
    glm::vec3 up{0.0f};
  };
  void DrawMap(std::size_t index);
  bool InObjectsShadow(std::size_t index, const glm::vec3& position_m) const;

  const RayCaster& real_;
  const RayCaster& objects_;
  glm::vec3 centre_m_;
  float radius_m_;
  int map_size_px_;
  std::vector<View> views_;
  // Per sample, row and column: how far the objects reach along the direction, from the sphere's
  // centre; far below where there is none.
  std::vector<float> reach_m_;
  std::size_t maps_drawn_ = 0;
};

}  // namespace pleinair
