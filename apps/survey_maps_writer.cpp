#include "apps/survey_maps_writer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calib/response.h"
#include "relight/survey/survey_maps.h"
#include "relight/volume/environment.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// The level that the brightest but one percent of a light map is shown at.
constexpr double kShownLevel = 0.9;
constexpr double kShownShare = 0.99;

double ExposureFor(const RgbImage& radiance) {
  std::vector<float> values;
  for (const glm::vec3& rgb : radiance.pixels) {
    const float value = std::max({rgb.x, rgb.y, rgb.z});
    if (value > 0.0f) values.push_back(value);
  }
  if (values.empty()) return 1.0;
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(kShownShare * double(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return kShownLevel / *nth;
}

void WriteBoth(const std::filesystem::path& folder,
               const std::string& name,
               const RgbImage& values,
               const RgbImage& shown,
               double exposure) {
  WriteExr(folder / (name + ".exr"), values, ExrPrecision::kFloat);
  WritePng(folder / (name + ".png"), CodesFromRadiance(shown, ResponseCurve::Srgb(), exposure));
}

using Json = nlohmann::ordered_json;

Json JsonOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

const char* NameOf(SunOrigin origin) {
  switch (origin) {
    case SunOrigin::kNone:
      return "none: it was below the horizon";
    case SunOrigin::kMap:
      return "map";
    case SunOrigin::kShadows:
      return "shadows";
    case SunOrigin::kClearSky:
      return "clear-sky model";
  }
  return "";
}

std::string Describe(const SurveyLight& light) {
  Json json;
  json["sun_direction_enu"] = JsonOf(light.sun_direction_enu);
  json["sun_from"] = NameOf(light.sun_origin);
  json["sun_clipped"] = light.sun_clipped;
  json["sun_irradiance_rgb"] = JsonOf(light.sun_irradiance_rgb);
  json["sun_irradiance_stddev_rgb"] = JsonOf(light.sun_irradiance_stddev_rgb);
  json["sky_irradiance_rgb"] = JsonOf(light.sky_irradiance_rgb);
  json["aerosol_optical_depth_500nm"] =
      light.aerosol_optical_depth_500nm ? Json(*light.aerosol_optical_depth_500nm) : Json(nullptr);
  json["albedo_stddev_rgb"] = JsonOf(light.albedo_stddev_rgb);
  json["notes"] = light.notes;
  return json.dump(2) + "\n";
}

}  // namespace

void WriteSurveyMaps(const PreparedScene& scene, const std::filesystem::path& folder) {
  if (!scene.survey) {
    throw std::runtime_error("prepare --maps: the sequence has no environment map to make maps in");
  }
  const SurveyMaps maps = MakeSurveyMaps(*scene.survey);
  MakeFolder(folder);
  WriteBoth(folder, "albedo", maps.albedo_rgb, maps.albedo_rgb, 1.0);
  RgbImage shown_normal = maps.normal_world;
  for (glm::vec3& normal : shown_normal.pixels) {
    if (normal != glm::vec3(0.0f)) normal = 0.5f * (normal + 1.0f);
  }
  WriteBoth(folder, "normal", maps.normal_world, shown_normal, 1.0);
  WriteBoth(folder, "ambient_weight", maps.ambient_weight, maps.ambient_weight, 1.0);
  WriteBoth(folder, "sun_visibility", maps.sun_visibility, maps.sun_visibility, 1.0);
  WriteBoth(folder, "sky", maps.sky_radiance, maps.sky_radiance, ExposureFor(maps.sky_radiance));
  WriteBoth(folder, "skyline", maps.skyline, maps.skyline, 1.0);
  WriteWholeText(folder / "survey.json", Describe(scene.survey->light));
  WriteBoth(folder, "relit", maps.relit, maps.relit, ExposureFor(maps.relit));
}

}  // namespace pleinair
