#include "apps/frame_faults.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "scene/half_float.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// The stated weather's probability below which the picture contradicts it. The other weathers start
// with a hundredth of theirs: the picture is then evidence of 1000 to 1.
constexpr double kContradictingShare = 0.1;
// The end of civil twilight: below, the sky's light is less than a thousandth of the day's.
constexpr double kNightRad = RadFromDeg(-6.0);

bool IsFilledByObjects(const Gray8Image& change) {
  constexpr std::uint8_t kCovered = static_cast<std::uint8_t>(PixelChange::kCovered);
  return !change.Empty() &&
         std::ranges::all_of(change.pixels, [](std::uint8_t pixel) { return pixel == kCovered; });
}

}  // namespace

void FrameFaults::Add(const Frame& frame, const FrameResult& result) {
  if (is_measured_in_pictures_) {
    if (result.estimate.samples_used == 0) {
      without_samples_.Add(frame.index);
    } else if (ModelMismatch(result.estimate)) {
      mismatching_.Add(frame.index);
    } else {
      AddWeather(frame, result.estimate);
    }
  }
  if (result.estimate.sky_camera.is_in_other_units) in_other_units_.Add(frame.index);
  if (result.estimate.sky_camera.shows_another_sun) under_another_sun_.Add(frame.index);
  not_finite_.Add(frame.defects.not_finite);
  clamped_.Add(result.clamped_pixels);
  if (result.is_drawn_without_sun) {
    without_sun_.Add(frame.index);
  } else if (result.drawn_lighting) {
    ++frames_without_colour_;
  }
  ++frames_;
  AddNight(result.estimate.lighting.sun);
  if (IsFilledByObjects(result.composite.change)) filled_.Add(frame.index);
  if (!result.plan.fits_budget) beyond_budget_.Add(frame.index);
}

void FrameFaults::AddNight(const DirectionalLight& sun) {
  if (sun.direction_enu == kNoSunDirectionEnu) return;  // Stated, or not known.
  const double elevation_rad = std::asin(std::clamp(sun.direction_enu.z, -1.0, 1.0));
  if (!(elevation_rad < kNightRad)) return;
  ++frames_at_night_;
  highest_sun_at_night_rad_ = std::max(highest_sun_at_night_rad_, elevation_rad);
}

void FrameFaults::AddWeather(const Frame& frame, const LightingEstimate& estimate) {
  if (!frame.weather || !estimate.weather_shares) return;
  const auto& shares = *estimate.weather_shares;
  if (shares[static_cast<std::size_t>(*frame.weather)] >= kContradictingShare) return;
  const auto most = std::max_element(shares.begin(), shares.end());
  contradicting_[kAllWeathers[std::distance(shares.begin(), most)]].Add(frame.index);
}

std::vector<std::string> FrameFaults::Notes() const {
  std::vector<std::string> notes;
  const auto add_pixels = [&notes](const PixelCount& count, const std::string& what) {
    if (count.pixels == 0) return;
    notes.push_back(fmt::format("{} pixels of {} frames are {}", count.pixels, count.frames, what));
  };
  add_pixels(not_finite_, "not finite: not used for the estimate, and written unchanged");
  add_pixels(clamped_, fmt::format("beyond half floats: written as {}", kLargestHalf));
  const auto add_frames =
      [&notes](const std::string& which, const FrameCount& count, const std::string& what) {
        if (count.frames == 0) return;
        notes.push_back(
            fmt::format("frames {}: {} (first: {}); {}", which, count.frames, count.first, what));
      };
  add_frames("whose light could not be measured",
             without_samples_,
             "no usable surface is in view; earlier frames, survey and weather give it");
  add_frames("that do not fit the model",
             mismatching_,
             "their light may be wrong: things cover the surfaces (see `pleinair site mask`), or "
             "mesh, pose, albedo or sun are wrong (see `pleinair site check`)");
  add_frames("whose fish-eye pictures are in other units or colours than their own",
             in_other_units_,
             "the light is scaled to the surfaces, see sky_camera in lighting.jsonl; `pleinair "
             "calibrate colour` ties the two cameras");
  add_frames("whose fish-eye pictures have another sun than their own",
             under_another_sun_,
             "it is measured on the surfaces; something hides it from the sky camera, or the sky's "
             "pictures are of another time");
  for (const auto& [weather, count] : contradicting_) {
    add_frames(fmt::format("that look {}, against the stated weather", NameOf(weather)),
               count,
               "the pictures decide; leave it out, or state it for each frame");
  }
  if (frames_ > 0 && frames_at_night_ == frames_) {
    notes.push_back(fmt::format(
        "the sun is at least {:.0f} deg below the horizon in all frames: objects get no "
        "sunlight; where the pictures show day, time_utc (is it UTC?) or the site is wrong",
        -DegFromRad(highest_sun_at_night_rad_)));
  }
  add_frames("drawn without a sun, as they show neither sun nor shade",
             without_sun_,
             "--weather clear states that the sun shone");
  add_frames("that virtual objects fill completely",
             filled_,
             "the camera is inside an object, or close to it");
  add_frames("whose effects are expected to take longer than the budget",
             beyond_budget_,
             "the most is left out of them that can be");
  if (frames_without_colour_ > 0) {
    notes.push_back(
        fmt::format("the estimated light of {} frames lacks a colour that daylight has: drawn with "
                    "more of it, see drawn_light in plan.jsonl",
                    frames_without_colour_));
  }
  return notes;
}

}  // namespace pleinair
