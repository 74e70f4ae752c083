#include "session/check/site_forecast.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "scene/ray_caster.h"
#include "session/session_choices.h"
#include "sunmodel/refraction.h"

namespace pleinair {
namespace {

using std::chrono::minutes;

// Share of the objects' area, by their triangles' middles.
double SunOn(const std::vector<VirtualObject>& objects,
             const RayCaster& real,
             const glm::dvec3& sun_direction_enu) {
  const glm::vec3 sun(sun_direction_enu);
  double facing_m2 = 0.0;
  double lit_m2 = 0.0;
  for (const VirtualObject& object : objects) {
    const Mesh& mesh = object.mesh;
    for (const glm::uvec3& corners : mesh.triangles) {
      const glm::vec3& a = mesh.positions_m[corners.x];
      const glm::vec3& b = mesh.positions_m[corners.y];
      const glm::vec3& c = mesh.positions_m[corners.z];
      const glm::vec3 twice_area = glm::cross(b - a, c - a);
      const double area_to_sun_m2 = 0.5 * glm::dot(twice_area, sun);
      if (!(area_to_sun_m2 > 0.0)) continue;
      facing_m2 += area_to_sun_m2;
      const glm::vec3 start_m = OffsetFromSurface((a + b + c) / 3.0f, glm::normalize(twice_area));
      if (!real.Occluded(start_m, sun)) lit_m2 += area_to_sun_m2;
    }
  }
  return facing_m2 > 0.0 ? lit_m2 / facing_m2 : 0.0;
}

// In which the light of this camera's frames will be.
LightUnits UnitsOf(const Sequence& sequence, FrameKind frames) {
  const FrameEntry& first = sequence.frames.front();
  if (first.exposure || (first.image && frames == FrameKind::kLinear)) return LightUnits::kAbsolute;
  return first.EffectiveExposure() ? LightUnits::kRelative : LightUnits::kRelativePerFrame;
}

UtcTime NextMultiple(UtcTime time, minutes step) {
  const auto since_epoch = time.time_since_epoch();
  const auto past = since_epoch % step;
  return past.count() == 0 ? time : time + (step - past);
}

}  // namespace

bool SunWillBeKnown(const SiteHour& hour) {
  return hour.light.estimate && *hour.light.estimate && (*hour.light.estimate)->sun_observable;
}

SiteDay ForecastDay(const LoadedSequence& loaded,
                    const SessionOptions& options,
                    UtcTime day,
                    minutes step) {
  if (step < minutes(1) || step > std::chrono::days(1)) {
    throw std::invalid_argument("step " + std::to_string(step.count()) +
                                " min: expected 1 to 1440");
  }
  const Sequence& sequence = loaded.sequence;
  if (!sequence.site) {
    throw std::runtime_error(sequence.file.string() +
                             ": site: expected latitude_deg, longitude_deg and height_m, which the "
                             "sun's way over a day follows from");
  }
  const Site& site = *sequence.site;
  SiteDay result;
  result.sun = FindSolarDay(site, day, StandardAtmosphere(site.height_m));

  LightForecastOptions forecast;
  forecast.view = options.pipeline.view;
  forecast.light = options.light;
  forecast.units = UnitsOf(sequence, options.frames);
  LightForecaster forecaster(loaded.scene, site, sequence.CameraOfFrame(0), forecast);
  const RayCaster real(loaded.site.model.mesh);
  const bool is_estimated = SourceOf(options, sequence) == SourceKind::kOutdoor;

  const bool is_up_all_day = !result.sun.sunrise && !result.sun.sunset && result.sun.sun_up_at_noon;
  if (!is_up_all_day && !result.sun.sunrise && !result.sun.sunset) return result;
  const auto half_a_day = std::chrono::hours(12);
  const UtcTime begin = result.sun.sunrise.value_or(result.sun.noon - half_a_day);
  const UtcTime end = result.sun.sunset.value_or(result.sun.noon + half_a_day);
  std::vector<UtcTime> times;
  for (UtcTime time = NextMultiple(begin, step); time <= end; time += step) times.push_back(time);
  if (times.empty()) times.push_back(result.sun.noon);
  for (std::size_t i = 0; i < times.size(); ++i) {
    SiteHour hour;
    hour.light = forecaster.At(times[i]);
    // Evenly chosen: one at each step of i * kMost / count.
    const std::size_t count = std::max(times.size(), kMostDayPictures);
    if (i > 0 && i * kMostDayPictures / count == (i - 1) * kMostDayPictures / count) {
      hour.light.picture = {};
    }
    if (!is_estimated) {
      hour.light.estimate.reset();
      hour.light.sun_relative_stddev.reset();
      hour.light.sky_relative_stddev.reset();
    }
    const glm::dvec3& sun = hour.light.sun.direction_enu;
    if (!loaded.site.objects.empty() && sun.z > 0.0) {
      hour.sun_on_objects = SunOn(loaded.site.objects, real, sun);
    }
    result.hours.push_back(std::move(hour));
  }
  return result;
}

}  // namespace pleinair
