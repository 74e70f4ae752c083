// How the light has changed between two frames, by the surfaces that both show.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "scene/lighting.h"

namespace pleinair {

// Sun and sky of two frames as the same surfaces have them: errors of albedo and of the model are
// nearly the same in both, so that the difference is better known than either. In the units of
// each frame's light: sun normal to the beam, sky horizontal.
struct LightChange {
  glm::dvec3 sun_before_rgb{0.0};
  glm::dvec3 sky_before_rgb{0.0};
  glm::dvec3 sun_after_rgb{0.0};
  glm::dvec3 sky_after_rgb{0.0};
  // Standard deviations of the difference, and the covariance of sun and sky.
  glm::dvec3 sun_stddev_rgb{0.0};
  glm::dvec3 sky_stddev_rgb{0.0};
  glm::dvec3 covariance_rgb{0.0};
};

// Compares each frame's samples with those of the frame before that lie at the same places, however
// the camera has moved. The radiance that was measured there before, over the one that the last
// light gives, is the place's own error; the light that then explains the new radiances is a robust
// fit (Tukey's weights). Towards the last light it has a prior as wide as three times what is seen
// to change: surfaces in the sun alone, which have not changed, are evidence of neither a new sun
// nor a new sky.
//
// One thread at a time.
class LightChangeWatch {
 public:
  // Compares an estimate's samples and light with those of the last call, and keeps them for the
  // next one. Returns nullopt for the first frame, where the two have hardly a place in common,
  // where these disagree with any light (a wrong pose, a hand before the lens), and where there is
  // no light.
  std::optional<LightChange> Compare(std::span<const DiffuseSample> samples,
                                     const Lighting& lighting);

 private:
  std::vector<DiffuseSample> last_samples_;
  Lighting last_lighting_;
};

}  // namespace pleinair
