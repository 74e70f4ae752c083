// What `pleinair tradeoff` sweeps: settings, their values, and what they are judged by.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "session/sequence_session.h"

namespace pleinair {

struct SweepValue {
  std::string text;
  std::function<void(SessionOptions&)> apply;
};

struct SweepAxis {
  // Which error and which time judge an axis.
  enum class Judge {
    kEstimate,  // Error of the light; what each frame pays, from the samples' pixels to covariance.
    kTransport,  // Error of the light; what a new sun costs, too: the view, drawing the samples.
    kPicture,    // Error of the composite; all of a frame but files.
  };
  std::string name;   // As --sweep has it.
  std::string words;  // What it is, and the option that sets it.
  Judge judge = Judge::kEstimate;
  bool rays_by_seed = false;  // Each seed prepares the site again: its rays are the noise.
  std::vector<SweepValue> values;
  std::string default_text;  // Among the values'.

  bool JudgesLight() const { return judge != Judge::kPicture; }
};

// What decides which settings mean something for a sequence.
struct SweepCase {
  bool light_is_fitted = true;  // From samples; false: a fish-eye measures it.
  bool has_pictures = true;     // Its truth has pictures with the object.
  bool is_indoors = false;
  InfluenceAt influence_at = InfluenceAt::kPixels;  // By default.
  int map_width = 0;  // Width of the environment map; 0: there is none.
};

std::vector<SweepAxis> SweepAxesFor(const SweepCase& sweep_case);

}  // namespace pleinair
