#include "apps/lighting_log.h"

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json ToJson(const std::optional<glm::dvec3>& v) { return v ? ToJson(*v) : Json(nullptr); }

// Standard deviations of the sum of the basis lights from `first` to `last` (the sun is 0), or none
// where the source can't know.
std::optional<glm::dvec3> StddevRgb(const Lighting& lighting, std::size_t first, std::size_t last) {
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return std::nullopt;
  glm::dvec3 rgb(0.0);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double variance = 0.0;
    for (std::size_t a = first; a <= last; ++a) {
      for (std::size_t b = first; b <= last; ++b) {
        variance += lighting.covariance[(3 * a + channel) * side + 3 * b + channel];
      }
    }
    rgb[static_cast<int>(channel)] = std::sqrt(std::max(0.0, variance));
  }
  return rgb;
}

RecordedLight RecordOf(const Lighting& lighting) {
  return {lighting.sun.direction_enu,
          lighting.sun.irradiance_rgb,
          lighting.SkyIrradianceRgb(),
          StddevRgb(lighting, 0, 0),
          StddevRgb(lighting, 1, lighting.sky.size())};
}

Json SkyShapeShares(const Lighting& lighting) {
  const glm::dvec3 sum = lighting.SkyIrradianceRgb();
  Json shares = Json::object();
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    glm::dvec3 share(0.0);
    for (int channel = 0; channel < 3; ++channel) {
      // A black sky has no shape: all of it is put on the first.
      share[channel] = sum[channel] > 0.0 ? lighting.sky[k].irradiance_rgb[channel] / sum[channel]
                                          : (k == 0 ? 1.0 : 0.0);
    }
    shares[lighting.sky[k].shape] = ToJson(share);
  }
  return shares;
}

void PutLight(const Lighting& lighting, Json& line) {
  const RecordedLight light = RecordOf(lighting);
  line["sun_direction_enu"] = ToJson(light.sun_direction_enu);
  line["sun_irradiance_rgb"] = ToJson(light.sun_irradiance_rgb);
  line["sky_irradiance_rgb"] = ToJson(light.sky_irradiance_rgb);
  line["sky_shape"] = SkyShapeShares(lighting);
  line["sun_irradiance_stddev_rgb"] = ToJson(light.sun_irradiance_stddev_rgb);
  line["sky_irradiance_stddev_rgb"] = ToJson(light.sky_irradiance_stddev_rgb);
}

Json ToJson(const ExposureChange& change) {
  const auto with_factor = [&](const char* kind) {
    return Json{{"kind", kind}, {"factor_rgb", ToJson(change.factor_rgb)}};
  };
  switch (change.kind) {
    case ExposureChange::Kind::kNone:
      return with_factor("none");
    case ExposureChange::Kind::kExposure:
      return with_factor("exposure");
    case ExposureChange::Kind::kLight:
      return {{"kind", "light"}, {"factor_rgb", nullptr}};
    case ExposureChange::Kind::kUnknown:
      break;
  }
  return {{"kind", "unknown"}, {"factor_rgb", nullptr}};
}

}  // namespace

LightingRecord RecordOf(int frame, const tl::expected<FrameResult, FrameError>& result) {
  LightingRecord record;
  record.frame = frame;
  if (!result) {
    record.error = result.error().reason;
    return record;
  }
  record.light = RecordOf(result->estimate.lighting);
  record.raw = RecordOf(result->raw_lighting);
  record.sun_observable = result->estimate.sun_observable;
  return record;
}

std::string LightingLine(const Frame& frame,
                         const FrameResult& result,
                         const std::string& sky_image,
                         std::optional<double> latency_ms) {
  const LightingEstimate& estimate = result.estimate;
  Json line;
  line["frame"] = frame.index;
  line["time_utc"] = FormatUtcTime(frame.time);
  PutLight(estimate.lighting, line);
  if (!sky_image.empty()) line["sky_image"] = sky_image;
  line["units"] = NameOf(estimate.units);
  if (estimate.units == LightUnits::kRelativePerFrame) {
    line["exposure_change"] = ToJson(estimate.exposure_change);
  }
  line["sun_observable"] = estimate.sun_observable;
  line["light_known"] = LightIsKnown(estimate.lighting);
  if (estimate.weather_shares) {
    for (const Weather weather : kAllWeathers) {
      line["weather"][std::string(NameOf(weather))] =
          (*estimate.weather_shares)[static_cast<std::size_t>(weather)];
    }
  }
  line["samples_used"] = estimate.samples_used;
  line["inlier_fraction"] = estimate.inlier_fraction;
  line["condition_number"] =
      std::isfinite(estimate.condition_number) ? Json(estimate.condition_number) : Json(nullptr);
  line["relative_residual"] = estimate.relative_residual;
  line["model_mismatch"] = ModelMismatch(estimate);
  if (!estimate.sky_radiance_rgb.empty()) {
    Json& regions = line["sky_radiance_rgb"] = Json::array();
    for (const glm::dvec3& radiance : estimate.sky_radiance_rgb) {
      regions.push_back(ToJson(radiance));
    }
    line["sky_camera"] = {{"factor_rgb", ToJson(estimate.sky_camera.factor_rgb)},
                          {"is_in_other_units", estimate.sky_camera.is_in_other_units},
                          {"shows_another_sun", estimate.sky_camera.shows_another_sun}};
  }
  if (result.daylight) {
    line["daylight"] = {{"samples", result.daylight->samples},
                        {"sky_share", result.daylight->sky_share},
                        {"maps_drawn", result.daylight->maps_drawn}};
  }
  line["sun_age_s"] = result.sun_age_s;
  if (latency_ms) line["latency_ms"] = *latency_ms;
  line["filter"] = {{"sun_frames", result.sun_filter.frames},
                    {"sun_held", result.sun_filter.held},
                    {"sky_frames", result.sky_filter.frames},
                    {"sky_held", result.sky_filter.held}};
  const StageTimes& ms = result.timing_ms;
  line["timing_ms"] = {{"read", ms.read},
                       {"transport", ms.transport},
                       {"estimate", ms.estimate},
                       {"relight", ms.relight},
                       {"probes", ms.probes},
                       {"render", ms.render},
                       {"readback", ms.readback},
                       {"write", ms.write}};
  PutLight(result.raw_lighting, line["raw"]);
  return line.dump();
}

std::string FailureLine(const FrameError& error) {
  Json line;
  line["frame"] = error.index;
  line["time_utc"] = FormatUtcTime(error.time);
  line["error"] = error.reason;
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace pleinair
