// Light straight from the sky that reaches virtual objects, and that they hide from real surfaces,
// by samples (grosch-2007, section 7).
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/daylight_shadows.h"
#include "relight/daylight/window_sampling.h"
#include "relight/transport/patch_scene.h"
#include "scene/sky_shape.h"

namespace pleinair {

struct DirectDaylightOptions {
  // Samples of each shape of the sky; grosch-2007 takes 64.
  DaylightSamplingOptions sampling{.samples = 256};
  DaylightShadowOptions shadows;
  // Known windows. None: they are searched for around the objects.
  std::vector<Window> windows;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// What the last Update did, over all shapes of the sky.
struct DirectDaylightSummary {
  std::size_t samples = 0;
  std::size_t maps_drawn = 0;
  double sky_share = 0.0;  // Share of the sky's light that samples come from; the shapes' mean.
};

// Set up once per pose of the objects. Samples are drawn for a unit of each shape of the sky, so
// that light stays a sum of basis lights: where the shapes stand, intensities alone change.
//
// Windows   restrict the samples only where the objects see no sky past them: outdoors, or in a
//           room that lacks a wall, samples are drawn from the entire sky.
class DirectDaylight {
 public:
  // `objects` are ObjectInterreflection::Objects(). They and `real` outlive this. Windows are
  // searched for in `room`, the same scene before its triangles were cut.
  DirectDaylight(const Mesh& room,
                 const RayCaster& real,
                 const PatchScene& objects,
                 const DirectDaylightOptions& options);

  // Bound of what a unit of `shape` brings to a vertex, and of what the objects hide of it from any
  // other place; without samples. Kept until a shape is passed that is not among the last ones.
  glm::vec3 LargestIrradiance(const std::shared_ptr<const SkyShape>& shape);

  // Draws samples of the shapes that are new (another object than at the last call).
  void Update(std::span<const std::shared_ptr<const SkyShape>> shapes);

  // Irradiance for a unit of shape `k`: that the objects' vertices get straight from the sky,
  const std::vector<glm::vec3>& OnObjects(std::size_t k) const { return skies_.at(k).on_objects; }
  // and that real surfaces lose of it to the objects.
  std::vector<glm::vec3> HiddenFrom(std::size_t k, std::span<const Receiver> receivers) const;

  const DirectDaylightSummary& Summary() const { return summary_; }
  // One line on what the samples are restricted to.
  const std::string& Note() const { return note_; }
  // The given windows or those found; none where they were not searched for.
  std::span<const Window> Windows() const { return windows_; }
  // The samples of all shapes, for a unit of each.
  std::vector<DaylightSample> Samples() const;

 private:
  struct Sky {
    std::shared_ptr<const SkyShape> shape;
    DaylightShadows shadows;
    std::vector<glm::vec3> on_objects;
    double sky_share = 0.0;
    std::vector<DaylightSample> samples;
  };
  const RayCaster& real_;
  const RayCaster& objects_;
  DaylightShadowOptions shadow_options_;
  BoundingSphere sphere_;
  std::vector<Receiver> vertices_;
  std::string note_;
  std::vector<Window> windows_;
  std::unique_ptr<DaylightSampler> sampler_;
  std::map<std::shared_ptr<const SkyShape>, glm::vec3> largest_;
  std::vector<Sky> skies_;
  DirectDaylightSummary summary_;
};

}  // namespace pleinair
