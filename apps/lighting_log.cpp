#include "apps/lighting_log.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

// Standard deviations of basis light `light` (the sun is 0), or null where the source can't know.
Json StddevRgb(const Lighting& lighting, std::size_t light) {
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return nullptr;
  Json rgb = Json::array();
  for (std::size_t i = 3 * light; i < 3 * light + 3; ++i) {
    rgb.push_back(std::sqrt(std::max(0.0, lighting.covariance[i * side + i])));
  }
  return rgb;
}

// Of the sum over the sky's shapes.
Json SkyStddevRgb(const Lighting& lighting) {
  const std::size_t shapes = lighting.sky.size();
  const std::size_t side = 3 * (1 + shapes);
  if (lighting.covariance.size() != side * side) return nullptr;
  Json rgb = Json::array();
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double variance = 0.0;
    for (std::size_t a = 1; a <= shapes; ++a) {
      for (std::size_t b = 1; b <= shapes; ++b) {
        variance += lighting.covariance[(3 * a + channel) * side + 3 * b + channel];
      }
    }
    rgb.push_back(std::sqrt(std::max(0.0, variance)));
  }
  return rgb;
}

Json SkyShapeShares(const Lighting& lighting) {
  const glm::dvec3 sum = lighting.SkyIrradianceRgb();
  Json shares = Json::object();
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    glm::dvec3 share(0.0);
    for (int channel = 0; channel < 3; ++channel) {
      // A black sky has no shape to tell: all of it is put on the first.
      share[channel] = sum[channel] > 0.0 ? lighting.sky[k].irradiance_rgb[channel] / sum[channel]
                                          : (k == 0 ? 1.0 : 0.0);
    }
    shares[lighting.sky[k].shape] = ToJson(share);
  }
  return shares;
}

void PutLight(const Lighting& lighting, Json& line) {
  line["sun_direction_enu"] = ToJson(lighting.sun.direction_enu);
  line["sun_irradiance_rgb"] = ToJson(lighting.sun.irradiance_rgb);
  line["sky_irradiance_rgb"] = ToJson(lighting.SkyIrradianceRgb());
  line["sky_shape"] = SkyShapeShares(lighting);
  line["sun_irradiance_stddev_rgb"] = StddevRgb(lighting, 0);
  line["sky_irradiance_stddev_rgb"] = SkyStddevRgb(lighting);
}

const char* NameOf(LightUnits units) {
  switch (units) {
    case LightUnits::kAbsolute:
      return "absolute";
    case LightUnits::kRelative:
      return "relative";
    case LightUnits::kRelativePerFrame:
      return "relative per frame";
  }
  return "";
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

std::string LightingLine(const Frame& frame, const FrameResult& result) {
  const LightingEstimate& estimate = result.estimate;
  Json line;
  line["frame"] = frame.index;
  line["time_utc"] = FormatUtcTime(frame.time);
  PutLight(estimate.lighting, line);
  line["units"] = NameOf(estimate.units);
  if (estimate.units == LightUnits::kRelativePerFrame) {
    line["exposure_change"] = ToJson(estimate.exposure_change);
  }
  line["sun_observable"] = estimate.sun_observable;
  line["samples_used"] = estimate.samples_used;
  line["inlier_fraction"] = estimate.inlier_fraction;
  line["condition_number"] =
      std::isfinite(estimate.condition_number) ? Json(estimate.condition_number) : Json(nullptr);
  line["relative_residual"] = estimate.relative_residual;
  if (!estimate.sky_radiance_rgb.empty()) {
    Json& regions = line["sky_radiance_rgb"] = Json::array();
    for (const glm::dvec3& radiance : estimate.sky_radiance_rgb) {
      regions.push_back(ToJson(radiance));
    }
  }
  if (result.daylight) {
    line["daylight"] = {{"samples", result.daylight->samples},
                        {"sky_share", result.daylight->sky_share},
                        {"maps_drawn", result.daylight->maps_drawn}};
  }
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
