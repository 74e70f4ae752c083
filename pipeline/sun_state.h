// Sun and clear sky from place and time, for the frames of one site.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "estimation/lighting_source.h"
#include "relight/survey/survey.h"
#include "scene/frame.h"
#include "scene/utc_time.h"
#include "sunmodel/clear_sky.h"
#include "sunmodel/site.h"

namespace pleinair {

// The apparent sun over `site`, under the standard atmosphere at its height, in the frame of the
// site's model.
SunState SunOverSite(const Site& site, UtcTime time);

// The sun's direction in a frame: the source's where it states one, else from place and time; for
// an overcast frame without either, kNoSunDirectionEnu.
// Throws std::invalid_argument when there is none of these.
SunState SunOfFrame(const std::optional<Site>& site, const Frame& frame);

// The clear-sky model, tied to a site by its survey. It is scaled per channel so that it reproduces
// the survey's own sun and sky at the survey's sun. This includes the site's turbidity and the
// camera's scale. A survey under cloud ties the scale only as well as its weather is known.
class ScaledClearSky {
 public:
  // Without a survey, or with one under a sun that was not up, only the model's ratios are used.
  ScaledClearSky(const std::optional<Site>& site, const SurveyLight* survey);

  // For kNoSunDirectionEnu, under a sun of usual height: for the colours of clouds.
  ClearSkyExpectation At(const glm::dvec3& sun_direction_enu) const;

 private:
  ClearSkyIrradiance Model(const glm::dvec3& sun_direction_enu) const;

  Site site_;  // Only its height matters to the model.
  bool absolute_ = false;
  double gain_stddev_ = 0.0;
  glm::dvec3 beam_scale_rgb_{1.0};
  glm::dvec3 diffuse_scale_rgb_{1.0};
};

}  // namespace pleinair
