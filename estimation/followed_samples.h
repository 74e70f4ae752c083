// The samples of a camera's frames, one after another: on the same surfaces while these are seen.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_source.h"
#include "estimation/sample_selection.h"
#include "scene/camera.h"
#include "scene/pixel_rect.h"
#include "scene/state_id.h"

namespace pleinair {

// Keeps a set of samples while the view stays, follows its places where the camera moves, and draws
// it again where too few of them are left. One thread at a time.
class FollowedSamples {
 public:
  // Throws std::invalid_argument as SampleSelectionOptions::Validate.
  explicit FollowedSamples(const SampleSelectionOptions& options);

  // As LightingSource's.
  std::optional<std::vector<PixelRect>> PixelsLookedAt(const Camera& camera) const;
  bool IsServedBy(const LightingObservation& observation) const;

  // Measures the frame's samples, with the camera's noise. Returns the time spent on drawing, in
  // ms; 0 when the set was kept.
  double Measure(const LightingObservation& observation);
  // Of the last frame measured; valid until the next call.
  std::span<DiffuseSample> Samples() { return samples_; }
  std::span<const DiffuseSample> Samples() const { return samples_; }
  // The number of places in view that could be samples, if they were usable.
  int Places() const { return set_.Size(); }

 private:
  SampleSelectionOptions options_;
  SampleSet set_;
  std::vector<DiffuseSample> samples_;
  // The key of the set.
  bool drawn_ = false;
  int drawn_size_ = 0;       // Size of the set when it was last filled.
  double usual_size_ = 0.0;  // Of the last sets; the largest is forgotten over some.
  bool may_grow_ = true;     // Whether another view may show many more surfaces than the set has.
  StateId geometry_id_;
  StateId sky_id_;
  StateId sun_id_;
  Camera camera_;

  bool SetFits(const SurfaceView& view) const;
  bool IsWorthFollowing() const;
  bool CanFollow(const SurfaceView& view) const;
  int FollowIn(const LightingObservation& observation, SampleSet& set) const;
  void Draw(const LightingObservation& observation);
  double Update(const LightingObservation& observation);
};

}  // namespace pleinair
