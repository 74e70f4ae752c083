// The sun that explains a picture's shadows best, wherever it stands.
#pragma once

#include <stop_token>

#include <glm/vec3.hpp>

#include "pipeline/internal/shadow_evidence.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct SunSearch {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};
  // Share of the misfit without any shadow that shadows explain: by the best sun, and by the best
  // one near where it is stated.
  double explained = 0.0;
  double explained_near_stated = 0.0;
  double agreement = 0.0;  // As AgreementOfStates, under the best.
};

// Over the upper hemisphere, to 1.5 deg. Near: within 3 deg of azimuth and 4 deg of elevation,
// which heights of casters are not known better than.
//
// `picture`  needs no shares.
// `stop`     what is returned after a stop has no meaning.
SunSearch SearchSun(const ShadowPicture& picture,
                    const RayCaster& caster,
                    const glm::dvec3& stated_sun_enu,
                    const std::stop_token& stop = {});

}  // namespace pleinair
