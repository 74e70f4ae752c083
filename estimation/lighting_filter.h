// The light over time: steadier than single frames where it stands still, at once where it changes.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/lighting.h"

namespace pleinair {

struct LightingFilterOptions {
  // Frames older than this have no say; after a longer gap a frame stands alone. > 0.
  double memory_s = 2.0;
  int most_frames = 64;  // That have a say. >= 1.
  // A difference of more standard deviations of frame-to-frame noise is a change. > 0.
  double change_sigmas = 4.0;

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// What the filter made of one light: the sun, or the sky as a whole.
struct FilterSpan {
  int frames = 1;     // That the reported light is the mean of.
  bool held = false;  // The frame's own light disagrees with them, and is not believed as yet.
};

struct FilteredLighting {
  Lighting lighting;
  FilterSpan sun;
  FilterSpan sky;
};

// The reported light is the mean, weighted by one over the estimates' variances, of the frames
// since the light last changed: of the longest run no two parts of which differ (after Bifet and
// Gavalda, Learning from time-changing data with adaptive windowing, SDM 2007), for the sun and the
// sky apart. A difference is told by the noise from frame to frame. That is a share of the stated
// deviations, most of which is error that all frames have in common; it is found from second
// differences, which a ramp does not move and a step moves twice.
//
//   step    The frame that shows it is held, as it could be a glitch; the next one confirms it and
//           ends the run: nothing from before the step is left in the mean.
//   glitch  A frame that the next one does not confirm is left out.
//   ramp    The run is as short as keeps the drift within the noise.
//   creep   Where the run ends for less than 3 % of the light, what was reported fades over to the
//           new mean, time constant 0.2 s: a camera that moves on to other surfaces takes their
//           errors along.
//   gap     After more than memory_s a frame stands alone: its estimate is left as it is.
//   order   A frame from before the last one is reported as it is and changes nothing. After three
//           in a row, or one by more than memory_s, the clock was set back: it starts anew.
//   units   With kRelativePerFrame the shares of the horizontal irradiance are filtered, and given
//           the frame's own total: the light stays that of the frame's picture, and a change of
//           exposure is none of light. A change of units or of sky shapes starts anew.
//
// The reported light is never negative. The covariance is the same mean of the frames' covariances:
// an upper bound whatever part of their errors they have in common (one frame more does not make
// albedos any surer). A held frame adds what it differs by.
//
// A pure function of the estimates so far. One thread at a time.
class LightingFilter {
 public:
  explicit LightingFilter(const LightingFilterOptions& options = {});

  // `raw` is the next frame's own estimate. One with a value that is not finite is given back as it
  // is.
  FilteredLighting Apply(const Lighting& raw, LightUnits units = LightUnits::kAbsolute);

 private:
  static constexpr std::size_t kSun = 0;
  static constexpr std::size_t kSky = 1;

  // One light of one frame in the filter's units.
  struct Reading {
    glm::dvec3 value{0.0};
    glm::dvec3 variance{0.0};  // As stated, and a little, so that it is never 0.
    bool left_out = false;
  };
  struct Entry {
    Lighting lighting;
    glm::dvec3 unit{1.0};  // What is 1 in the filter's units.
    std::array<Reading, 2> readings;
  };
  struct Track {
    std::size_t begin = 0;  // Of the run, in entries_.
    bool pending = false;   // The last entry disagrees with the run.
    // Squared second differences over what the stated variances would make of them.
    std::deque<double> roughness;
  };
  struct Mean {
    glm::dvec3 value{0.0};
    glm::dvec3 variance{0.0};  // If the stated variances were all noise.
    int frames = 0;
  };

  LightingFilterOptions options_;
  LightUnits units_ = LightUnits::kAbsolute;
  int late_frames_ = 0;
  std::deque<Entry> entries_;
  std::array<Track, 2> tracks_;
  // In the order of Lighting::covariance, in the filter's units.
  std::vector<double> reported_;  // Last.
  std::vector<double> fading_;    // What is left of it beside the mean.

  bool Continues(const Lighting& raw, LightUnits units) const;
  void Restart(LightUnits units);
  void Forget(UtcTime now);
  void Add(const Lighting& raw);
  void UpdateNoise(std::size_t light);
  double NoiseShare(std::size_t light) const;
  double WeightOf(std::size_t light, std::size_t entry) const;
  Mean MeanOver(std::size_t light, std::size_t begin, std::size_t end) const;
  bool Differ(std::size_t light, const Mean& a, const Mean& b, double* sigmas = nullptr) const;
  void UpdateRun(std::size_t light);
  void CutWhereItChanged(std::size_t light);
  bool IsInRun(std::size_t light, std::size_t entry) const;
  FilteredLighting Report() const;
  // Where the run of a light has just ended for little, its old one fades.
  void Ease(const std::array<bool, 2>& has_ended, FilteredLighting& result);
};

}  // namespace pleinair
