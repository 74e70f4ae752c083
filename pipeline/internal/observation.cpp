#include "pipeline/internal/observation.h"

namespace pleinair {
namespace {

std::optional<SurveyedLight> SurveyedLightOf(const PreparedScene& scene,
                                             const ScaledClearSky& clear_sky) {
  if (!scene.survey || !scene.survey_time) return std::nullopt;
  const SurveyLight& light = scene.survey->light;
  return SurveyedLight{*scene.survey_time,
                       light.sun_irradiance_rgb,
                       light.sun_irradiance_stddev_rgb,
                       light.sky_irradiance_rgb,
                       clear_sky.At(light.sun_direction_enu),
                       light.sun_hidden};
}

}  // namespace

// Errors of guesses differ mostly between surfaces: a person compares with neighbouring surfaces.
double PlaneAlbedoStddev(const PreparedScene& scene) {
  constexpr double kPartOfEach = 0.7;
  const glm::dvec3& stddev = scene.albedo_stddev_rgb;
  return scene.survey ? 0.0 : kPartOfEach * (stddev.x + stddev.y + stddev.z) / 3.0;
}

LightingObservation Observe(const PreparedScene& scene,
                            const ScaledClearSky& clear_sky,
                            const Frame& frame,
                            const SurfaceView& view,
                            const SunState& sun) {
  return {frame,
          view,
          sun,
          clear_sky.At(sun.direction_enu),
          std::nullopt,
          scene.albedo_stddev_rgb,
          PlaneAlbedoStddev(scene),
          SurveyedLightOf(scene, clear_sky)};
}

}  // namespace pleinair
