#include "pipeline/sun_state.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "sunmodel/refraction.h"
#include "sunmodel/sun_position.h"

namespace pleinair {
namespace {

// A survey whose beam is below this share of the clear one was taken under cloud: it ties the units
// of the sky, but not those of the beam.
constexpr double kLeastClearBeamShare = 0.3;

}  // namespace

SunState SunOverSite(const Site& site, UtcTime time) {
  const SunPosition sun = ComputeSunPosition(site, time);
  return {ApparentDirection(sun.direction_enu, StandardAtmosphere(site.height_m)),
          sun.angular_radius_rad};
}

SunState SunOfFrame(const std::optional<Site>& site, const Frame& frame) {
  if (frame.sun_direction_enu) {
    SunState sun;
    sun.direction_enu = *frame.sun_direction_enu;
    return sun;
  }
  if (!site) {
    throw std::invalid_argument(
        "frame " + std::to_string(frame.index) +
        ": neither a site nor a sun_direction_enu to tell where the sun is");
  }
  return SunOverSite(*site, frame.time);
}

ScaledClearSky::ScaledClearSky(const std::optional<Site>& site, const SurveyLight* survey)
    : site_(site.value_or(Site{})) {
  if (survey == nullptr || survey->sun_origin == SunOrigin::kClearSky) return;
  const ClearSkyIrradiance model = Model(survey->sun_direction_enu);
  if (std::min({model.beam_rgb.x, model.beam_rgb.y, model.beam_rgb.z}) <= 0.0) return;
  const glm::dvec3 diffuse_scale = survey->sky_irradiance_rgb / model.diffuse_rgb;
  const glm::dvec3 beam_scale = survey->sun_irradiance_rgb / model.beam_rgb;
  // The sky under broken cloud is brighter than the clear one, never so by the factor that hides
  // the beam: a beam far weaker than the sky's scale speaks of a cloud before the disc.
  if (beam_scale.y < kLeastClearBeamShare * diffuse_scale.y) return;
  beam_scale_rgb_ = beam_scale;
  diffuse_scale_rgb_ = diffuse_scale;
  absolute_ = true;
}

ClearSkyExpectation ScaledClearSky::At(const glm::dvec3& sun_direction_enu) const {
  const ClearSkyIrradiance model = Model(sun_direction_enu);
  return {model.beam_rgb * beam_scale_rgb_, model.diffuse_rgb * diffuse_scale_rgb_, absolute_};
}

ClearSkyIrradiance ScaledClearSky::Model(const glm::dvec3& sun_direction_enu) const {
  const double elevation_rad =
      std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
  return ComputeClearSky(site_, elevation_rad);
}

}  // namespace pleinair
