// What was wrong with a run's frames, in a note for each kind of fault.
#pragma once

#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/frame_pipeline.h"
#include "scene/frame.h"
#include "scene/weather.h"

namespace pleinair {

// Counts frames by fault: pixels that composites could not be made from unchanged, nothing to
// measure light on, surfaces that differ from the model or from a sky camera's light, a stated
// weather that the picture contradicts, a light without a colour that daylight has, no sign of sun
// or shade, a time at night, nothing but virtual objects in the picture, more effects than the
// budget has time for.
class FrameFaults {
 public:
  // `is_measured_in_pictures`: whether the light is that of the frames' own surfaces.
  explicit FrameFaults(bool is_measured_in_pictures)
      : is_measured_in_pictures_(is_measured_in_pictures) {}

  void Add(const Frame& frame, const FrameResult& result);
  std::vector<std::string> Notes() const;

 private:
  struct PixelCount {
    std::int64_t pixels = 0;
    int frames = 0;
    void Add(std::int64_t more) {
      pixels += more;
      frames += more > 0 ? 1 : 0;
    }
  };
  struct FrameCount {
    int frames = 0;
    int first = 0;
    void Add(int frame) {
      if (frames++ == 0) first = frame;
    }
  };

  void AddWeather(const Frame& frame, const LightingEstimate& estimate);
  void AddNight(const DirectionalLight& sun);

  bool is_measured_in_pictures_;
  FrameCount without_samples_;
  FrameCount mismatching_;
  FrameCount in_other_units_;
  FrameCount under_another_sun_;
  std::map<Weather, FrameCount> contradicting_;  // By the weather that they look like.
  PixelCount not_finite_;
  PixelCount clamped_;
  int frames_without_colour_ = 0;
  int frames_ = 0;
  int frames_at_night_ = 0;
  double highest_sun_at_night_rad_ = -std::numbers::pi;
  FrameCount without_sun_;
  FrameCount filled_;
  FrameCount beyond_budget_;
};

}  // namespace pleinair
