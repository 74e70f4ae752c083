// The error of an estimate of sun and sky against the truth.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "datasets/lighting_record.h"
#include "datasets/statistics.h"
#include "datasets/truth.h"

namespace pleinair {

// The score of one frame. Values without meaning (a ratio to a black sky, the colour of a black
// light) or unknown ones (a standard deviation) are none. Relative light has its direction and its
// ratio of sun to sky, and nothing else to compare.
struct LightScore {
  // Mean over RGB of |error|, over the sequence's largest true sun (mean over RGB).
  std::optional<double> sun_error;
  // Mean over RGB of |error|, over the mean over RGB of this frame's true sky.
  std::optional<double> sky_error;
  // Mean over RGB of |sun / sky over the true sun / sky - 1|: the error that is defined for
  // relative light. None where the true sun is below 5 % of the sequence's largest.
  std::optional<double> sun_to_sky_error;
  // Angles between the estimated and the true RGB vectors: an error of colour, independent of the
  // intensity.
  std::optional<double> sun_colour_angle_rad;
  std::optional<double> sky_colour_angle_rad;
  std::optional<double> sun_direction_error_rad;
  // |error| in standard deviations, per channel; 0 where both are 0.
  std::optional<glm::dvec3> sun_error_sigmas;
  std::optional<glm::dvec3> sky_error_sigmas;
  // Mean standard deviation over the mean clear-sky beam.
  std::optional<double> sun_stddev_of_clear_beam;
  std::optional<double> sky_stddev_of_clear_beam;

  // Whether all channels of sun and sky are within 3 standard deviations, and those within 40 % of
  // the clear-sky beam: required where the picture does not distinguish sun and sky.
  std::optional<bool> SaysWhatItDoesNotKnow() const;
};

// Mean over RGB of the brightest true sun.
double LargestTrueSun(const std::vector<TruthFrame>& truth);

// Returns the score; none where the record has no light. `clear_beam_rgb` is the beam under a clear
// sky at the frame's time.
std::optional<LightScore> ScoreLight(const RecordedLight& estimate,
                                     const TruthFrame& truth,
                                     double largest_true_sun,
                                     const glm::dvec3& clear_beam_rgb);

// |log| of the estimated sun over sky, over the true one, per channel: independent of an unknown
// exposure and white balance. At most log(100), the value for no sun or no sky at all. None where
// the record has no light, and where sun_to_sky_error is none.
std::optional<glm::dvec3> LogSunOverSkyError(const RecordedLight& estimate,
                                             const TruthFrame& truth,
                                             double largest_true_sun);

// Share of the truths (channels of all frames) within 1 and 2 standard deviations of the estimate;
// a calibrated estimate has 0.68 and 0.95.
struct SigmaCoverage {
  int count = 0;
  double within_1 = 0.0;
  double within_2 = 0.0;
};

// Statistics over frames. An entry is none where no frame has that score.
struct LightSummary {
  int frames = 0;
  std::optional<Distribution> sun_error;
  std::optional<Distribution> sky_error;
  std::optional<Distribution> sun_to_sky_error;
  std::optional<Distribution> sun_colour_angle_rad;
  std::optional<Distribution> sky_colour_angle_rad;
  std::optional<Distribution> sun_direction_error_rad;
  std::optional<SigmaCoverage> sun_sigma;
  std::optional<SigmaCoverage> sky_sigma;
  // Frames for which LightScore::SaysWhatItDoesNotKnow is true, of the with_stddev frames with
  // known standard deviations.
  int says_what_it_does_not_know = 0;
  int with_stddev = 0;
};

// Summarises the scores of frames; entries that are none are left out.
LightSummary SummariseLight(const std::vector<LightScore>& scores);

}  // namespace pleinair
