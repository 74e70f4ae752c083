#include "pipeline/north_correction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "pipeline/internal/middle_frames.h"
#include "pipeline/shadow_direction.h"
#include "pipeline/sun_state.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

constexpr int kFramesLookedAt = 24;
// A wide range is searched coarsely first; the fine one is the finder's own.
constexpr double kCoarseStepRad = RadFromDeg(1.0);
constexpr int kCoarsePixels = 2000;
constexpr double kMostSigmasOff = 3.0;

bool IsChosen(int index, std::optional<int> count) {
  return !count || IsMiddleOfAPart(index, *count, kFramesLookedAt);
}

struct Found {
  ShadowDirection shadow;
  int frames = 0;
};

// With the sun turned by `turn_rad` in advance.
Found FindTurn(FrameSource& frames,
               const Site& site,
               ShadowDirectionFinder finder,
               double turn_rad) {
  Found found;
  const std::optional<int> count = frames.Count();
  while (const auto frame = frames.Next()) {
    if (!*frame || !IsChosen((*frame)->index, count) || (*frame)->sun_direction_enu) continue;
    finder.Add(**frame, TurnedClockwise(SunOverSite(site, (*frame)->time).direction_enu, turn_rad));
    ++found.frames;
  }
  found.shadow = finder.Result().all;
  return found;
}

}  // namespace

std::optional<WeighedNorth> WeighNorth(double measured_azimuth_rad,
                                       double measured_stddev_rad,
                                       double stated_stddev_rad) {
  const double stated = stated_stddev_rad * stated_stddev_rad;
  const double seen = measured_stddev_rad * measured_stddev_rad;
  if (std::abs(measured_azimuth_rad) > kMostSigmasOff * std::sqrt(stated + seen)) {
    return std::nullopt;
  }
  return WeighedNorth{measured_azimuth_rad * stated / (stated + seen),
                      std::sqrt(stated * seen / (stated + seen))};
}

NorthCorrection CorrectNorth(const std::function<std::unique_ptr<FrameSource>()>& open_frames,
                             const Site& site,
                             const Mesh& mesh,
                             std::span<const std::string> diffuse_regions,
                             double stated_stddev_rad) {
  if (!(stated_stddev_rad > 0.0) || !std::isfinite(stated_stddev_rad)) {
    throw std::invalid_argument("stated_stddev_rad is " + std::to_string(stated_stddev_rad) +
                                ": expected above 0");
  }
  Site true_north = site;
  true_north.model_north_azimuth_rad = 0.0;
  const ShadowDirectionOptions fine;
  const double range_rad = std::min(kMostSigmasOff * stated_stddev_rad, std::numbers::pi);
  double turn_rad = 0.0;
  if (range_rad > fine.largest_offset_rad) {
    ShadowDirectionOptions coarse;
    coarse.largest_offset_rad = range_rad;
    coarse.step_rad = kCoarseStepRad;
    coarse.pixels = kCoarsePixels;
    turn_rad = FindTurn(*open_frames(), true_north, {mesh, diffuse_regions, coarse}, 0.0)
                   .shadow.azimuth_offset_rad;
  }
  const Found found = FindTurn(*open_frames(), true_north, {mesh, diffuse_regions, fine}, turn_rad);

  NorthCorrection north;
  north.stddev_rad = stated_stddev_rad;
  north.frames = found.frames;
  // The sun turns one way in the model's frame as the model's north turns the other.
  north.shadows_azimuth_rad = -(turn_rad + found.shadow.azimuth_offset_rad);
  north.shadows_stddev_rad = found.shadow.stddev_rad;
  if (!found.shadow.determined) {
    north.reason =
        found.frames == 0 ? "no frame's sun follows from place and time" : found.shadow.reason;
    return north;
  }
  const auto weighed =
      WeighNorth(north.shadows_azimuth_rad, north.shadows_stddev_rad, stated_stddev_rad);
  if (!weighed) {
    north.contradicts = true;
    north.reason = "they contradict the stated deviation";
    return north;
  }
  north.determined = true;
  north.north_azimuth_rad = weighed->azimuth_rad;
  north.stddev_rad = weighed->stddev_rad;
  return north;
}

}  // namespace pleinair
