#include "pipeline/frame_view.h"

#include <chrono>
#include <cmath>

#include "pipeline/sun_state.h"

namespace pleinair {
namespace {

// The middle of the raster cell that holds `time`.
UtcTime SnapToRaster(UtcTime time, double step_s) {
  if (step_s <= 0.0) return time;
  const auto step_ns = static_cast<std::int64_t>(std::llround(step_s * 1e9));
  const std::int64_t ticks_ns = time.time_since_epoch().count();
  std::int64_t cell = ticks_ns / step_ns;
  if (ticks_ns % step_ns < 0) --cell;
  return UtcTime(std::chrono::nanoseconds(cell * step_ns + step_ns / 2));
}

}  // namespace

TransportTime TransportSun(const std::optional<Site>& site,
                           const Frame& frame,
                           const SunState& sun,
                           const TransportSteps& steps) {
  if (frame.sun_direction_enu || !site) return {frame.time, sun, sun};
  const UtcTime time = SnapToRaster(frame.time, steps.sun_s);
  return {time,
          SunOverSite(*site, time),
          SunOverSite(*site, SnapToRaster(frame.time, steps.bounces_s))};
}

std::vector<SampleRegionPolygon> SampleRegionsOf(const Frame& frame) {
  std::vector<SampleRegionPolygon> regions;
  regions.reserve(frame.sample_polygons.size());
  for (const SamplePolygon& polygon : frame.sample_polygons) {
    regions.push_back({polygon.group, polygon.polygon_px, polygon.sun});
  }
  return regions;
}

}  // namespace pleinair
