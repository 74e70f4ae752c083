#include "pipeline/sun_state.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/lighting.h"
#include "sunmodel/north.h"
#include "sunmodel/refraction.h"
#include "sunmodel/sun_position.h"

namespace pleinair {
namespace {

// A survey whose beam is below this share of the clear one was taken under cloud: it ties the units
// of the sky, but not those of the beam.
constexpr double kLeastClearBeamShare = 0.3;

// Assumed deviation of the factor between the survey's units and the model's. A clear survey is
// reproduced, with 5 % for radiometry. Under cloud the sky sends anything from a tenth to a half of
// the clear global irradiance.
constexpr double kClearGainStddev = 0.05;
constexpr double kCloudedShare = 0.35;
constexpr double kCloudedGainStddev = 0.5;

// An overcast sky without place has some sun above it. One of usual height: the colour of clouds
// hardly depends on it.
glm::dvec3 SunAboveClouds(const glm::dvec3& sun_direction_enu) {
  constexpr glm::dvec3 kUsualSunEnu{0.0, -0.8, 0.6};
  return sun_direction_enu == kNoSunDirectionEnu ? kUsualSunEnu : sun_direction_enu;
}

}  // namespace

SunState SunOverSite(const Site& site, UtcTime time) {
  const SunPosition sun = ComputeSunPosition(site, time);
  const glm::dvec3 about_true_north =
      ApparentDirection(sun.direction_enu, StandardAtmosphere(site.height_m));
  return {site.model_north_azimuth_rad == 0.0
              ? about_true_north
              : TurnedClockwise(about_true_north, -site.model_north_azimuth_rad),
          sun.angular_radius_rad};
}

SunState SunOfFrame(const std::optional<Site>& site, const Frame& frame) {
  if (frame.sun_direction_enu) {
    SunState sun;
    sun.direction_enu = *frame.sun_direction_enu;
    return sun;
  }
  if (!site) {
    if (frame.weather == Weather::kOvercast) return {kNoSunDirectionEnu};
    throw std::invalid_argument(
        "expected a site, or the frame's sun_direction_enu, or \"overcast\" as its weather: "
        "nothing says where the sun is");
  }
  return SunOverSite(*site, frame.time);
}

ScaledClearSky::ScaledClearSky(const std::optional<Site>& site, const SurveyLight* survey)
    : site_(site.value_or(Site{})) {
  if (survey == nullptr) return;
  const ClearSkyIrradiance model = Model(survey->sun_direction_enu);
  if (std::min({model.beam_rgb.x, model.beam_rgb.y, model.beam_rgb.z}) <= 0.0) return;
  const glm::dvec3 diffuse_scale = survey->sky_irradiance_rgb / model.diffuse_rgb;
  const glm::dvec3 beam_scale = survey->sun_irradiance_rgb / model.beam_rgb;
  if (!(std::min({diffuse_scale.x, diffuse_scale.y, diffuse_scale.z}) > 0.0)) return;
  absolute_ = true;
  // The sky under broken cloud is brighter than the clear one, but never by the factor that hides
  // the beam. So a beam far weaker than the sky's scale means a cloud before the disc.
  const bool shows_beam = survey->sun_origin != SunOrigin::kClearSky &&
                          beam_scale.y >= kLeastClearBeamShare * diffuse_scale.y;
  if (shows_beam) {
    beam_scale_rgb_ = beam_scale;
    diffuse_scale_rgb_ = diffuse_scale;
    gain_stddev_ = kClearGainStddev;
    return;
  }
  // Clouds are as grey as the light above them: no colour of the clear sky is scaled by itself.
  const double height = std::max(0.0, survey->sun_direction_enu.z);
  const double measured = MeanOf(survey->sky_irradiance_rgb);
  const double expected = kCloudedShare * MeanOf(model.diffuse_rgb + height * model.beam_rgb);
  beam_scale_rgb_ = diffuse_scale_rgb_ = glm::dvec3(measured / expected);
  gain_stddev_ = kCloudedGainStddev;
}

ClearSkyExpectation ScaledClearSky::At(const glm::dvec3& sun_direction_enu) const {
  const glm::dvec3 sun = SunAboveClouds(sun_direction_enu);
  const ClearSkyIrradiance model = Model(sun);
  ClearSkyExpectation clear_sky;
  clear_sky.beam_rgb = model.beam_rgb * beam_scale_rgb_;
  clear_sky.diffuse_rgb = model.diffuse_rgb * diffuse_scale_rgb_;
  clear_sky.sine_of_elevation = sun.z;
  clear_sky.absolute = absolute_;
  clear_sky.gain_stddev = gain_stddev_;
  return clear_sky;
}

ClearSkyIrradiance ScaledClearSky::Model(const glm::dvec3& sun_direction_enu) const {
  const double elevation_rad =
      std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
  return ComputeClearSky(site_, elevation_rad);
}

}  // namespace pleinair
