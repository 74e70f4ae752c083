#include "session/survey_map_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "pipeline/sun_state.h"
#include "relight/survey/map_sun.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "session/direction_text.h"
#include "session/map_sun_check.h"
#include "sunmodel/angles.h"
#include "sunmodel/clear_sky.h"

namespace pleinair {
namespace {

const char* Describe(MapSunKind kind) {
  switch (kind) {
    case MapSunKind::kFlatTop:
      return "a disc that is cut off";
    case MapSunKind::kPlateau:
      return "the middle of what is cut off";
    case MapSunKind::kGlow:
      return "the middle of its glow";
    case MapSunKind::kDisc:
      break;
  }
  return "its disc";
}

// What a map shows of the sun that contradicts where it is stated or computed.
struct MapContradiction {
  std::string words;
  // Where the map's light is measured instead: at a disc that is near enough to be the sun.
  std::optional<glm::dvec3> sun_direction_enu;
};

// None where the map's own sun agrees with the stated direction, or is not visible.
// By night and in rooms the disc may be a lamp.
std::optional<MapContradiction> ContradictionOfMap(const SurveyMap& map,
                                                   bool stated,
                                                   bool is_indoors) {
  constexpr double kFarthestRad = RadFromDeg(30.0);  // Two hours of a clock that is off.
  const auto found = CompareWithMapSun(map.radiance, map.sun_direction_enu);
  if (!found) return std::nullopt;
  const MapSun& shown = found->shown;
  MapContradiction contradiction;
  const bool may_be_a_lamp = is_indoors || !(map.sun_direction_enu.z > 0.0);
  if (!may_be_a_lamp && shown.kind == MapSunKind::kDisc && found->angle_rad <= kFarthestRad) {
    contradiction.sun_direction_enu = shown.direction_enu;
  }
  contradiction.words = fmt::format(
      "the map shows the sun {:.1f} deg ({:.1f} of azimuth) from where it is {}: at {} ({}), not "
      "at {}: {} may be wrong{}",
      DegFromRad(found->angle_rad),
      DegFromRad(found->turn_rad),
      stated ? "stated" : "computed",
      AzimuthAndElevation(shown.direction_enu),
      Describe(shown.kind),
      AzimuthAndElevation(map.sun_direction_enu),
      stated ? "environment.sun_direction_enu, or the map's orientation,"
             : "the map's orientation, north (site.north_uncertain_deg lets the map correct it), "
               "place or time (zone)",
      contradiction.sun_direction_enu ? "; the map's own sun is used for its light" : "");
  return contradiction;
}

// The clockwise turn of a map into the model's frame, where the site's model is turned from true
// north. 0 where the map's sun is given in the model's frame already, or none is found.
double TurnToModel(const Sequence& sequence,
                   const RgbImage& radiance,
                   std::vector<std::string>& notes) {
  Site true_north = sequence.site.value();
  if (true_north.model_north_azimuth_rad == 0.0) return 0.0;
  true_north.model_north_azimuth_rad = 0.0;
  const EnvironmentEntry& entry = *sequence.environment;
  const glm::dvec3 about_true_north = SunOverSite(true_north, entry.time).direction_enu;
  const glm::dvec3 in_model = SunOverSite(*sequence.site, entry.time).direction_enu;
  const std::optional<MapSun> shown = FindMapSun(radiance);
  const double to_model = shown ? glm::distance(shown->direction_enu, in_model) : 0.0;
  const double to_true = shown ? glm::distance(shown->direction_enu, about_true_north) : 0.0;
  const double apart_rad = std::abs(to_model - to_true);
  if (!shown || apart_rad < shown->uncertain_rad) {
    notes.push_back(entry.image.string() +
                    ": its sun does not determine whether it is turned as the model is, or "
                    "stands to true north: assumed to be turned as the model");
    return 0.0;
  }
  if (to_model < to_true) return 0.0;
  notes.push_back(entry.image.string() +
                  ": its sun stands to true north: it is turned along with the model");
  return -sequence.site->model_north_azimuth_rad;
}

RgbImage ReadMap(const std::filesystem::path& file) {
  if (std::filesystem::is_regular_file(file) && !HoldsRadiance(file)) {
    throw std::runtime_error(fmt::format(
        "{}: expected an OpenEXR or Radiance HDR picture as survey map, found {}: merge a bracket "
        "(pleinair calibrate merge), or leave `environment` out and use the mesh's albedos",
        file.string(),
        DescribeContent(file)));
  }
  return ReadRadianceImage(file);
}

}  // namespace

std::vector<std::string> FindSunInMap(Sequence& sequence) {
  if (!sequence.environment || sequence.environment->sun_direction_enu || sequence.site) return {};
  EnvironmentEntry& entry = *sequence.environment;
  RgbImage radiance = ReadMap(sequence.folder / entry.image);
  RepairRadiance(radiance);
  const std::optional<MapSun> shown = FindMapSun(radiance);
  entry.sun_direction_enu = shown ? shown->direction_enu : kNoSunDirectionEnu;
  if (shown) {
    return {fmt::format(
        "{}: no place and time: the sun is where the map shows it, at {} ({}), in all frames that "
        "do not state their own",
        entry.image.string(),
        AzimuthAndElevation(shown->direction_enu),
        Describe(shown->kind))};
  }
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    FrameEntry& frame = sequence.frames[i];
    if (frame.sun_direction_enu) continue;
    if (sequence.WeatherOfFrame(i).value_or(Weather::kOvercast) != Weather::kOvercast) {
      throw std::runtime_error(
          fmt::format("{}: frames[{}].sun_direction_enu: expected a value, as its weather is "
                      "\"{}\": there is no "
                      "site, and no sun in {}",
                      sequence.file.string(),
                      i,
                      NameOf(*sequence.WeatherOfFrame(i)),
                      entry.image.string()));
    }
    frame.weather = Weather::kOvercast;
  }
  std::string note =
      entry.image.string() +
      ": no place and time, and no sun in the map: frames that do not state their own are "
      "without sun (overcast)";
  constexpr double kWorthAWord = 1e-3;
  if (const double cut_off = ShareCutOff(radiance); cut_off >= kWorthAWord) {
    note += fmt::format(
        "; but {:.1f} % of its upper half is cut off at one value, and the sun may be there: "
        "environment.sun_direction_enu, or a site, would say where",
        100.0 * cut_off);
  }
  return {note};
}

LoadedSurveyMap LoadSurveyMap(const Sequence& sequence,
                              bool is_indoors,
                              std::vector<std::string>& notes) {
  const EnvironmentEntry& entry = *sequence.environment;
  LoadedSurveyMap loaded;
  SurveyMap& map = loaded.map;
  const std::filesystem::path file = sequence.folder / entry.image;
  map.radiance = ReadMap(file);
  if (map.radiance.width != 2 * map.radiance.height) {
    throw std::runtime_error(
        fmt::format("{}: expected a lat-long picture, twice as wide as high, found {}x{}",
                    file.string(),
                    map.radiance.width,
                    map.radiance.height));
  }
  const ImageDefects defects = RepairRadiance(map.radiance);
  if (defects.Count() > 0) {
    notes.push_back(entry.image.string() + ": " + std::to_string(defects.not_finite) +
                    " pixels not finite and " + std::to_string(defects.negative) +
                    " negative were repaired");
  }
  map.position_m = entry.position_m;
  map.time = entry.time;
  if (sequence.north_stddev_rad > 0.0) {
    constexpr double kMostTurnedRad = RadFromDeg(20.0);  // As far as shadows are sought to correct.
    map.misplacement.turned_rad = std::min(2.0 * sequence.north_stddev_rad, kMostTurnedRad);
  }
  if (entry.sun_direction_enu) {
    map.sun_direction_enu = glm::normalize(*entry.sun_direction_enu);
  } else if (sequence.site) {
    const SunState sun = SunOverSite(*sequence.site, entry.time);
    map.sun_direction_enu = sun.direction_enu;
    map.sun_angular_radius_rad = sun.angular_radius_rad;
    loaded.turned_rad = TurnToModel(sequence, map.radiance, notes);
    if (loaded.turned_rad != 0.0) map.radiance = TurnedLatLong(map.radiance, loaded.turned_rad);
  } else {
    const std::optional<MapSun> shown = FindMapSun(map.radiance);
    map.sun_direction_enu = shown ? shown->direction_enu : kNoSunDirectionEnu;
  }
  if (entry.sun_direction_enu || sequence.site) {
    const bool is_stated = entry.sun_direction_enu.has_value();
    if (const auto contradiction = ContradictionOfMap(map, is_stated, is_indoors)) {
      notes.push_back(entry.image.string() + ": " + contradiction->words);
      map.sun_direction_enu = contradiction->sun_direction_enu.value_or(map.sun_direction_enu);
    }
  }
  const double elevation_rad = std::atan2(
      map.sun_direction_enu.z, std::hypot(map.sun_direction_enu.x, map.sun_direction_enu.y));
  const ClearSkyIrradiance clear = ComputeClearSky(sequence.site.value_or(Site{}), elevation_rad);
  if (std::min({clear.diffuse_rgb.x, clear.diffuse_rgb.y, clear.diffuse_rgb.z}) > 0.0) {
    map.clear_sky_beam_to_diffuse_rgb = clear.beam_rgb / clear.diffuse_rgb;
  }
  return loaded;
}

}  // namespace pleinair
