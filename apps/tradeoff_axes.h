// What `pleinair tradeoff` sweeps: settings, their values, and what they are judged by.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/effect.h"
#include "session/session_options.h"

namespace pleinair {

struct SweepValue {
  std::string text;
  std::vector<std::string> assignments;  // "name=value", as session/settings.h has them.
  std::optional<Effect> without;         // Switched off.

  void ApplyTo(SessionOptions& options) const;
};

// A setting that is swept.
struct SweepAxis {
  // Which error and which time judge an axis.
  enum class Judge {
    kEstimate,  // Error of the light; what each frame pays, from the samples' pixels to covariance.
    kTransport,  // Error of the light; what a new sun costs, too: the view, drawing the samples.
    kPicture,    // Error of the composite; all of a frame but files.
  };
  std::string setting;                  // As session/settings.h and --sweep have it.
  std::vector<std::string> depends_on;  // "name=value": without these it changes nothing.
  Judge judge = Judge::kEstimate;
  bool rays_by_seed = false;  // Each seed prepares the site again: its rays are the noise.
  std::vector<SweepValue> values;
  std::string default_text;  // Among the values'.

  bool JudgesLight() const { return judge != Judge::kPicture; }
  // What it is, and what it depends on.
  std::string Words() const;
};

// What decides which settings mean something for a sequence.
struct SweepCase {
  bool light_is_fitted = true;  // From samples; false: a fish-eye measures it.
  bool has_pictures = true;     // Its truth has pictures with the object.
  bool is_indoors = false;
  InfluenceAt influence_at = InfluenceAt::kPixels;  // By default.
  int map_width = 0;  // Width of the environment map; 0: there is none.
  SurfaceViewOptions::ReceiversAt receivers_at = SurfaceViewOptions::ReceiversAt::kPixels;
};

std::vector<SweepAxis> SweepAxesFor(const SweepCase& sweep_case);

}  // namespace pleinair
