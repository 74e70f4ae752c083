#include "session/check/clock_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "calib/exif_time.h"
#include "pipeline/sun_state.h"
#include "scene/angle_between.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

constexpr double kDegreesAnHour = 15.0;
constexpr double kDegreesAMinute = 0.25;

double Hours(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::ratio<3600>>(time).count();
}

// "2 h 05 min"
std::string DurationText(std::chrono::nanoseconds time) {
  const auto whole = std::chrono::round<minutes>(time < time.zero() ? -time : time).count();
  return whole % 60 == 0   ? fmt::format("{} h", whole / 60)
         : whole / 60 == 0 ? fmt::format("{} min", whole)
                           : fmt::format("{} h {:02} min", whole / 60, whole % 60);
}

// "UTC+2", "UTC-3:30"
std::string ZoneText(minutes offset) {
  const auto size = std::abs(offset.count());
  std::string text = fmt::format("UTC{}{}", offset.count() < 0 ? '-' : '+', size / 60);
  if (size % 60 != 0) text += fmt::format(":{:02}", size % 60);
  return text;
}

// Of whole hours, and of the half ones that are in use.
minutes NearestZone(minutes offset) {
  constexpr int kHalfHours[] = {-19, -7, -5, 7, 9, 11, 13, 19, 21};
  minutes nearest = minutes{60} * std::lround(static_cast<double>(offset.count()) / 60.0);
  for (const int half_hours : kHalfHours) {
    const minutes zone{30 * half_hours};
    if (std::chrono::abs(zone - offset) < std::chrono::abs(nearest - offset)) nearest = zone;
  }
  return nearest;
}

// The camera's clock as if it were UTC. None without a usable time.
struct CameraClock {
  UtcTime local;
  std::optional<UtcTime> utc;
};
std::optional<CameraClock> ClockOf(const std::filesystem::path& file) {
  const std::optional<ExifTime> exif = ReadExifTime(file);
  if (!exif) return std::nullopt;
  try {
    CameraClock clock{ParseUtcTime(exif->local_time + "Z"), std::nullopt};
    if (!exif->utc_offset.empty()) clock.utc = ParseUtcTime(exif->local_time + exif->utc_offset);
    return clock;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

// Empty where they go together.
std::string ContradictionOfClock(const CameraClock& clock,
                                 UtcTime stated,
                                 const Sequence& sequence) {
  constexpr seconds kTolerance{60};
  if (clock.utc) {
    const auto off = stated - *clock.utc;
    if (std::chrono::abs(off) <= kTolerance) return {};
    return fmt::format("EXIF says {}, with its zone; time_utc is {} {} ({:.2f} deg of sun)",
                       FormatUtcTime(*clock.utc),
                       DurationText(off),
                       off > off.zero() ? "later" : "earlier",
                       kDegreesAMinute * 60.0 * std::abs(Hours(off)));
  }
  if (!sequence.site) return {};
  const auto zone = clock.local - stated;
  const double by_longitude_h =
      std::remainder(DegFromRad(sequence.site->longitude_rad), 360.0) / kDegreesAnHour;
  // Clocks are up to 1.1 h behind the sun (north-east Norway) and 3 h ahead of it (west China, or
  // Galicia in summer).
  constexpr double kMostBehindH = 1.25;
  constexpr double kMostAheadH = 3.1;
  const double ahead_h = Hours(zone) - by_longitude_h;
  if (std::abs(ahead_h) <= kMostAheadH && ahead_h >= -kMostBehindH) {
    // A zone of 0 far from Greenwich is a camera on UTC, or a time that was copied.
    constexpr double kNearGreenwichH = 0.6;
    if (std::chrono::abs(zone) > kTolerance || std::abs(by_longitude_h) < kNearGreenwichH) {
      return {};
    }
    return fmt::format(
        "time_utc is the same as EXIF's time, which is the camera's local time and states no zone; "
        "at this longitude the sun is {:.1f} h from Greenwich's",
        by_longitude_h);
  }
  return fmt::format(
      "EXIF's local time {} is {} {} time_utc; at this longitude the sun is {:+.1f} h from "
      "Greenwich's",
      FormatUtcTime(clock.local).substr(0, 19),
      DurationText(zone),
      zone < zone.zero() ? "before" : "after",
      by_longitude_h);
}

// Exposure value at ISO 100: some 5 in lit streets at night, 9 at sunset, 15 in the sun.
std::optional<double> ExposureValue(const FrameEntry& frame) {
  if (!frame.exposure_s || !frame.iso || !frame.f_number) return std::nullopt;
  return std::log2(*frame.f_number * *frame.f_number / *frame.exposure_s * 100.0 / *frame.iso);
}

// Root mean square over the suns.
double Apart(std::span<const SeenSun> suns, const std::function<glm::dvec3(UtcTime)>& computed) {
  double squares = 0.0;
  for (const SeenSun& sun : suns) {
    const double angle = AngleBetweenRad(sun.direction_enu, computed(sun.time));
    squares += angle * angle;
  }
  return std::sqrt(squares / static_cast<double>(suns.size()));
}

struct Explanation {
  double apart_rad = 0.0;
  std::string words;
};

}  // namespace

SiteWarnings CheckFrameTimes(const Sequence& sequence) {
  SiteWarnings warnings;
  const auto warn_once = [&](SiteWarning warning) {
    // The first of each kind: a recording has thousands of frames.
    for (const SiteWarning& known : warnings) {
      if (known.what == warning.what) return;
    }
    warnings.push_back(std::move(warning));
  };
  constexpr const char* kTimeHelp =
      "check the time zone, and the sign of site.longitude_deg (east is positive)";
  bool all_at_night = true;
  double highest_sun_rad = -std::numbers::pi;
  constexpr std::size_t kMostLooks = 50;
  const std::size_t stride = std::max<std::size_t>(1, sequence.frames.size() / kMostLooks);
  for (std::size_t i = 0; i < sequence.frames.size(); i += stride) {
    const FrameEntry& frame = sequence.frames[i];
    const std::string where = fmt::format("frames[{}].time_utc", i);
    for (const auto& picture : {frame.image_ldr, frame.image}) {
      if (!picture || frame.video_frame) continue;
      const auto clock = ClockOf(sequence.folder / *picture);
      if (!clock) continue;
      const std::string contradiction = ContradictionOfClock(*clock, frame.time, sequence);
      if (contradiction.empty()) continue;
      warn_once({"a frame's time is not that of its picture",
                 where,
                 contradiction,
                 "time_utc is UTC: local time minus its offset (UTC+2: 2 h less); correct all "
                 "frames, and environment.time_utc, which may have the same error"});
    }
    if (!sequence.site || frame.sun_direction_enu) {
      all_at_night = false;
      continue;
    }
    const double elevation_rad =
        std::asin(std::clamp(SunOverSite(*sequence.site, frame.time).direction_enu.z, -1.0, 1.0));
    highest_sun_rad = std::max(highest_sun_rad, elevation_rad);
    constexpr double kNightRad = RadFromDeg(-6.0);
    const auto exposure_value = ExposureValue(frame);
    all_at_night = all_at_night && elevation_rad < kNightRad && !exposure_value;
    constexpr double kDaylight = 9.0;
    if (exposure_value && *exposure_value > kDaylight && elevation_rad < kNightRad) {
      warn_once({"a picture by daylight has a time at night",
                 where,
                 fmt::format("the exposure is one of daylight (value {:.1f} at ISO 100), and the "
                             "sun is at {:.1f} deg",
                             *exposure_value,
                             DegFromRad(elevation_rad)),
                 kTimeHelp});
    }
  }
  if (all_at_night && !sequence.frames.empty()) {
    warn_once({"all frames have times at night",
               "frames[0].time_utc",
               fmt::format("the sun is at {:.1f} deg at most", DegFromRad(highest_sun_rad)),
               std::string("if the pictures show day: ") + kTimeHelp});
  }
  return warnings;
}

SiteWarnings CheckFrameOrder(const Sequence& sequence) {
  SiteWarnings warnings;
  const std::vector<FrameEntry>& frames = sequence.frames;
  const auto seconds_before = [&](std::size_t i) {
    return std::chrono::duration<double>(frames[i].time - frames[i - 1].time).count();
  };
  std::vector<std::size_t> back;
  std::vector<std::size_t> too_long;
  double longest_s = 0.0;  // Around the first of too_long.
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (seconds_before(i) < 0.0) back.push_back(i);
    // The longer one: in a bracket a long exposure follows a short one.
    const double around_s = std::max(seconds_before(i), i > 1 ? seconds_before(i - 1) : 0.0);
    if (!(around_s > 0.0) || !(frames[i - 1].exposure_s.value_or(0.0) > 1.5 * around_s)) continue;
    if (too_long.empty()) longest_s = around_s;
    too_long.push_back(i - 1);
  }
  if (!back.empty()) {
    warnings.push_back(
        {fmt::format("frames earlier than the one before them: {}", back.size()),
         fmt::format("frames[{}].time_utc", back.front()),
         fmt::format(
             "it is {:.6g} s before frames[{}]", -seconds_before(back.front()), back.front() - 1),
         "list frames in the order in which they were taken: light is steadied, and "
         "motion known, from frame to frame"});
  }
  if (!too_long.empty()) {
    warnings.push_back({fmt::format("frames whose shutter is open for longer than a frame lasts: "
                                    "{}",
                                    too_long.size()),
                        fmt::format("frames[{}].exposure_s", too_long.front()),
                        fmt::format("{:.6g} s, where frames are {:.6g} s apart",
                                    *frames[too_long.front()].exposure_s,
                                    longest_s),
                        "it is in seconds; correct it, or time_utc"});
  }
  return warnings;
}

std::vector<std::string> ExplanationsOf(std::span<const SeenSun> suns, const Site& site) {
  std::vector<Explanation> explanations;
  if (suns.empty()) return {};
  double stddev_rad = 0.0;
  for (const SeenSun& sun : suns) stddev_rad = std::max(stddev_rad, sun.stddev_rad);

  // A clock that is ahead, by what the pictures show best.
  const auto with_clock = [&](minutes ahead) {
    return Apart(suns, [&](UtcTime time) { return SunOverSite(site, time - ahead).direction_enu; });
  };
  minutes best_ahead{0};
  double best_clock_rad = with_clock(best_ahead);
  for (minutes ahead{-14 * 60}; ahead <= minutes{14 * 60}; ahead += minutes{2}) {
    const double apart = with_clock(ahead);
    if (apart < best_clock_rad) std::tie(best_clock_rad, best_ahead) = std::pair(apart, ahead);
  }
  // A zone is likelier than a clock that is off by anything.
  const minutes zone = NearestZone(best_ahead);
  constexpr double kLittleWorseRad = RadFromDeg(1.5);
  const double zone_rad = zone == minutes{0} ? 1e9 : with_clock(zone);
  if (zone_rad <= std::max(best_clock_rad + kLittleWorseRad, 2.0 * stddev_rad)) {
    explanations.push_back(
        {zone_rad,
         fmt::format("times that are {} too {}, as local time of {} written as UTC",
                     DurationText(zone),
                     zone > minutes{0} ? "late" : "early",
                     ZoneText(zone))});
  } else if (best_ahead != minutes{0}) {
    explanations.push_back({best_clock_rad,
                            fmt::format("a clock that is {} {}",
                                        DurationText(best_ahead),
                                        best_ahead > minutes{0} ? "fast" : "slow")});
  }
  if (std::abs(site.longitude_rad) > RadFromDeg(2.0)) {
    Site other = site;
    other.longitude_rad = -site.longitude_rad;
    explanations.push_back(
        {Apart(suns, [&](UtcTime time) { return SunOverSite(other, time).direction_enu; }),
         "a longitude with the wrong sign (east is positive)"});
  }
  double best_turn_deg = 0.0;
  double best_turn_rad = 1e9;
  for (double turn_deg = -180.0; turn_deg < 180.0; turn_deg += 0.5) {
    const double apart = Apart(suns, [&](UtcTime time) {
      return TurnedClockwise(SunOverSite(site, time).direction_enu, RadFromDeg(turn_deg));
    });
    if (apart < best_turn_rad) std::tie(best_turn_rad, best_turn_deg) = std::pair(apart, turn_deg);
  }
  explanations.push_back(
      {best_turn_rad,
       fmt::format("a +Y that points to true azimuth {:.1f} deg, not north", -best_turn_deg)});

  std::sort(explanations.begin(), explanations.end(), [](const auto& a, const auto& b) {
    return a.apart_rad < b.apart_rad;
  });
  // As good as the pictures can say, and not much worse than the best.
  constexpr double kExplainedRad = RadFromDeg(3.0);
  const double most_rad = std::max(kExplainedRad, 3.0 * stddev_rad);
  std::vector<std::string> words;
  for (const Explanation& explanation : explanations) {
    if (explanation.apart_rad > most_rad ||
        explanation.apart_rad > explanations.front().apart_rad + kExplainedRad) {
      continue;
    }
    words.push_back(
        fmt::format("{} ({:.1f} deg left)", explanation.words, DegFromRad(explanation.apart_rad)));
  }
  return words;
}

}  // namespace pleinair
