// Runs recordings with one imperfection at a time, and scores the light and the pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/imperfection_dials.h"
#include "relight/progress.h"
#include "session/sequence_session.h"

namespace pleinair {

struct ImperfectionSettings {
  std::vector<std::filesystem::path> sequences;  // Each with its truth/.
  // Of all runs. Where its cache is empty, what is prepared is removed after the sweep.
  SessionOptions session;
  int seeds = 2;
  int frames_limit = 4;  // Spread over those that have a picture with the object.
};

// Figures of one run.
struct ImperfectionFigures {
  // |log| of sun over sky against the truth's, median over channels and the frames with a true sun.
  std::optional<double> sun_over_sky;
  // Errors as in LightScore, median over frames; none where exposure is withheld.
  std::optional<double> sun;
  std::optional<double> sky;
  // Root mean square over the pixels that objects cover, in code values, against the object really
  // there as the same camera takes it.
  std::optional<double> object_codes;

  bool operator==(const ImperfectionFigures&) const = default;
};

struct ImperfectionResult {
  double size = 0.0;
  std::vector<ImperfectionFigures> runs;  // One a seed.
  std::string failure;                    // Why a run or a frame failed; empty: none did.
};

struct ImperfectRecording {
  std::string name;
  int frames = 0;
  ImperfectionResult perfect;      // Without imperfections, but 8-bit frames with noise.
  ImperfectionResult without_map;  // With true mean albedos; where compared with.
  std::vector<std::vector<ImperfectionResult>> dials;  // In their order, one a size.

  // What a dial's sizes are to be compared with.
  const ImperfectionResult& BaseOf(const ImperfectionDial& dial) const {
    return dial.without_map ? without_map : perfect;
  }
};

// Light is estimated from frames: sequences that a fish-eye lights are refused. Results depend on
// the sequences, seeds and settings alone.
// Throws  std::runtime_error where a sequence cannot be read, or has no truth.
std::vector<ImperfectRecording> MeasureImperfections(const ImperfectionSettings& settings,
                                                     const std::vector<ImperfectionDial>& dials,
                                                     const Progress& progress);

}  // namespace pleinair
