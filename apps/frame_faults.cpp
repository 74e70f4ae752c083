#include "apps/frame_faults.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "scene/half_float.h"

namespace pleinair {
namespace {

// The stated weather's probability below which the picture contradicts it. The other weathers start
// with a hundredth of theirs: the picture is then evidence of 1000 to 1.
constexpr double kContradictingShare = 0.1;

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
  not_finite_.Add(frame.defects.not_finite);
  clamped_.Add(result.clamped_pixels);
  frames_without_colour_ += result.drawn_lighting ? 1 : 0;
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
  for (const auto& [weather, count] : contradicting_) {
    add_frames(fmt::format("that look {}, against the stated weather", NameOf(weather)),
               count,
               "the pictures decide; leave it out, or state it for each frame");
  }
  if (frames_without_colour_ > 0) {
    notes.push_back(
        fmt::format("the estimated light of {} frames lacks a colour that daylight has: drawn with "
                    "more of it, see drawn_light in plan.jsonl",
                    frames_without_colour_));
  }
  return notes;
}

}  // namespace pleinair
