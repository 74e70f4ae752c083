// The light over time: steadier than single frames while it is constant, without delay where it
// changes.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/fading_light.h"
#include "estimation/lighting_source.h"
#include "estimation/seen_steps.h"
#include "scene/lighting.h"

namespace pleinair {

// Set-up of the filter.
struct LightingFilterOptions {
  // Older frames have no weight; after a longer gap a frame is not filtered. > 0.
  double memory_s = 2.0;
  int most_frames = 64;  // That have weight. >= 1.
  // A difference of more standard deviations of frame-to-frame noise is a change. > 0.
  double change_sigmas = 4.0;

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// How a frame's picture fits its model, and the frame before.
struct FrameFit {
  // What is left between picture and model, as LightingEstimate::relative_residual has it; 0:
  // unknown.
  double misfit = 0.0;
  // Up to this one albedos explain it (TrustedResidual).
  double trusted_misfit = kLargestTrustedResidual;
  // Since the frame of the last call.
  std::optional<LightChange> change = std::nullopt;
};

// The filter's result for one light: the sun, or the entire sky.
struct FilterSpan {
  int frames = 1;     // The number of frames that the reported light is the mean of.
  bool held = false;  // The frame's own light disagrees with them, and is not used yet.
};

// The reported light, and how many frames it rests on.
struct FilteredLighting {
  Lighting lighting;
  FilterSpan sun;
  FilterSpan sky;
};

// The reported light is the mean of the frames since the light last changed, with weights of
// inverse variance, for the sun and for the sky separately. These frames are the longest run no two
// parts of which differ (after Bifet and Gavalda, Learning from time-changing data with adaptive
// windowing, SDM 2007). Two parts differ by the noise from frame to frame. That noise is a share of
// the stated deviations, most of which is error that all frames have in common. It is found from
// second differences, which a ramp does not change, and of which a step changes two. In a blurred
// or badly posed frame the samples fit the model less well than usual. It has an error beside the
// noise, by how much less well they fit, which several such frames have in common.
//
//   step    The frame that shows it is held, as it could be a glitch. The next one confirms it and
//           ends the run: the mean then has nothing from before the step.
//   glitch  A frame that the next one does not confirm is left out.
//   misfit  A frame whose model explains its picture far less well than those before, and too badly
//           to be trusted, is held and changes nothing: a hand before the lens, a pose that is
//           wrong. After memory_s of such frames they are the light.
//   ramp    The run is as short as keeps the drift within the noise.
//   seen    A step that surfaces in common with the last frame show, too (LightChange), is followed
//           at once. What they do not show of it are the errors of other surfaces, which a moving
//           camera brings in: the reported light fades to the new mean, time constant 1 s. Sun and
//           sky that change by one factor may be a wrong exposure: such a step is held.
//   creep   Without surfaces in common, the light fades for less than 3 % of it, time constant
//           0.2 s.
//   gap     After more than memory_s a frame is not filtered.
//   order   A frame from before the last one is reported unfiltered and changes nothing. After
//           three in a row, or one by more than memory_s, the clock was set back: the filter
//           restarts.
//   units   With kRelativePerFrame the shares of the horizontal irradiance are filtered, and scaled
//           by the frame's own total: the light stays that of the frame's picture, and a change of
//           exposure is no change of light. A change of units or of sky shapes restarts the filter.
//
// The reported light is never negative. The covariance is the same mean of the frames' covariances.
// This is an upper bound, whatever part of their errors they have in common: one more frame does
// not make albedos more certain. A held frame adds its difference.
//
// A pure function of the estimates so far. One thread at a time.
class LightingFilter {
 public:
  explicit LightingFilter(const LightingFilterOptions& options = {});

  // Returns the filtered light. `raw` is the next frame's own estimate; one with a value that is
  // not finite is returned unchanged.
  FilteredLighting Apply(const Lighting& raw,
                         LightUnits units = LightUnits::kAbsolute,
                         const FrameFit& fit = {});

 private:
  static constexpr std::size_t kSun = 0;
  static constexpr std::size_t kSky = 1;

  // One light of one frame in the filter's units.
  struct Reading {
    glm::dvec3 value{0.0};
    glm::dvec3 variance{0.0};  // As stated, plus a little, so that it is never 0.
    bool left_out = false;
  };

  // Entries of a run, from `begin` up to before `end`.
  struct Span {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  struct Entry {
    Lighting lighting;
    std::optional<SeenSteps> since_last;  // By the surfaces in common with the entry before.
    double misfit = 0.0;
    glm::dvec3 unit{1.0};  // The value that is 1 in the filter's units.
    std::array<Reading, 2> readings;
  };
  struct Track {
    std::size_t begin = 0;  // The run's first frame, in entries_.
    bool pending = false;   // The last entry disagrees with the run.
    double noise_share = 1.0;
    // Squared second differences over their expectation from the stated variances.
    std::deque<double> roughness;
  };
  // Variances of the noise from frame to frame: as usual, and by a misfit that is not.
  struct Noise {
    glm::dvec3 usual{0.0};
    glm::dvec3 excess{0.0};
  };
  struct Mean {
    glm::dvec3 value{0.0};
    glm::dvec3 variance{0.0};  // Variance of the noise from frame to frame.
    int frames = 0;
  };

  LightingFilterOptions options_;
  LightUnits units_ = LightUnits::kAbsolute;
  int late_frames_ = 0;
  UtcTime last_time_{};                        // Of the last frame in order, held ones included.
  std::optional<SeenSteps> since_last_entry_;  // Until the frame at last_time_.
  std::deque<Entry> entries_;
  std::array<Track, 2> tracks_;
  // Median over the frames before the newest; 0 where they are few or their misfits are unknown.
  double usual_misfit_ = 0.0;
  FadingLight fading_;

  bool Continues(const Lighting& raw, LightUnits units) const;
  void Restart(LightUnits units);
  void DropOldEntries(UtcTime now);
  Entry EntryOf(const Lighting& raw, const FrameFit& fit) const;
  void UpdateNoise(std::size_t light);
  double NoiseShare(std::size_t light) const;
  double MedianMisfit(std::size_t entries) const;
  Noise NoiseOf(std::size_t light, std::size_t entry) const;
  double WeightOf(std::size_t light, std::size_t entry) const;
  Mean MeanOver(std::size_t light, std::size_t begin, std::size_t end) const;
  bool Differ(const Mean& a, const Mean& b, double* sigmas = nullptr) const;
  // What surfaces in common say of the change from one mean of entries to a later one.
  std::optional<SeenStep> ChangeBetween(std::size_t light, const Span& from, const Span& to) const;
  bool IsSeenToChange(std::size_t light, const Span& run, std::size_t entry) const;
  void UpdateRun(std::size_t light);
  void CutWhereItChanged(std::size_t light);
  std::size_t EndOfRun(std::size_t light) const;
  bool IsInRun(std::size_t light, std::size_t entry) const;
  bool HasRuns() const;
  // The runs' light in the units and at the time of `frame`, which is held or the last entry.
  FilteredLighting Report(const Entry& frame, bool is_held) const;
};

}  // namespace pleinair
