#include "relight/survey/survey_maps.h"

#include "relight/transport/surface_gather.h"
#include "relight/volume/environment.h"
#include "scene/lat_long.h"
#include "scene/sky_shape.h"

namespace pleinair {
namespace {

RgbImage SkylineMap(const Skyline& skyline, LatLongSize size) {
  RgbImage map(size.width, size.height, glm::vec3(0.0f));
  if (skyline.Empty()) return map;
  for (int y = 0; y < size.height / 2; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
      map.At(x, y) = glm::vec3(skyline.hidden[SkyTable::CellOf(direction)]);
    }
  }
  return map;
}

}  // namespace

SurveyMaps MakeSurveyMaps(const Survey& survey) {
  const SurfaceView& view = survey.view;
  SurveyMaps maps;
  maps.albedo_rgb = view.albedo_rgb;
  maps.normal_world = view.normal_world;
  maps.ambient_weight = RgbImage(view.Width(), view.Height());
  survey.gather->Blend(
      survey.gather->Rays().FromSky(*SeenPast(survey.skyline, MakeUniformSkyShape())),
      maps.ambient_weight.pixels);
  maps.sun_visibility = RgbImage(view.Width(), view.Height());
  for (std::size_t i = 0; i < view.sun_visibility.pixels.size(); ++i) {
    maps.sun_visibility.pixels[i] = glm::vec3(view.sun_visibility.pixels[i]);
  }
  maps.sky_radiance = survey.light.sky_radiance;
  maps.skyline = SkylineMap(survey.skyline, {view.Width(), view.Height()});

  Lighting own_light;
  own_light.sun.direction_enu = survey.light.sun_direction_enu;
  own_light.sun.irradiance_rgb = survey.light.sun_irradiance_rgb;
  own_light.sky = {{"survey", survey.light.sky_irradiance_rgb}};
  const auto shape = OwnSkyShape(survey.light, survey.skyline);
  const std::vector<EnvironmentBasis> basis{
      EnvironmentOfSun(survey, survey.light.sun_direction_enu),
      EnvironmentOfSky(survey, 0, *shape)};
  SynthesiseEnvironment(basis, own_light, maps.relit);
  return maps;
}

}  // namespace pleinair
