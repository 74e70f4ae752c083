#include "estimation/followed_samples.h"

#include <algorithm>
#include <chrono>

#include "estimation/sample_noise.h"

namespace pleinair {
namespace {

// Least share of a set drawn for an earlier frame; with fewer samples left, the frame gets its own
// set.
constexpr double kLeastShareOfKeptSet = 0.8;
// The same of a set whose places lie in a new view: some of them will be occluded.
constexpr double kLeastShareInView = 0.85;

}  // namespace

FollowedSamples::FollowedSamples(const SampleSelectionOptions& options) : options_(options) {
  options.Validate();
}

std::optional<std::vector<PixelRect>> FollowedSamples::PixelsLookedAt(const Camera& camera) const {
  if (!IsWorthFollowing() || camera.intrinsics != camera_.intrinsics) return std::nullopt;
  std::vector<PixelRect> pixels = set_.PixelsFollowed(camera);
  if (static_cast<double>(pixels.size()) < kLeastShareInView * drawn_size_) return std::nullopt;
  return pixels;
}

bool FollowedSamples::IsServedBy(const LightingObservation& observation) const {
  if (!SetFits(observation.view) && !CanFollow(observation.view)) return false;
  if (!IsWorthFollowing()) return false;
  SampleSet followed = set_;
  return FollowIn(observation, followed) >= kLeastShareOfKeptSet * drawn_size_;
}

double FollowedSamples::Measure(const LightingObservation& observation) {
  const double drawing_ms = Update(observation);
  if (const Frame& frame = observation.frame; frame.noise != nullptr) {
    ApplySignalNoise(*frame.noise, frame.exposure.value_or(1.0), samples_);
  }
  return drawing_ms;
}

bool FollowedSamples::SetFits(const SurfaceView& view) const {
  return drawn_ && !set_.IsShortOfUsablePixels() && view.geometry_id.IsSet() &&
         view.geometry_id == geometry_id_ && view.sky_id == sky_id_ && view.sun_id == sun_id_ &&
         view.camera == camera_;
}

// A set of a view that showed hardly any surface is not enough for the next one, though all of it
// may be found there again.
bool FollowedSamples::IsWorthFollowing() const {
  constexpr double kLeastShareOfUsual = 0.5;
  constexpr double kLeastShareOfWanted = 0.1;
  if (!drawn_ || drawn_size_ == 0 || drawn_size_ < kLeastShareOfUsual * usual_size_) return false;
  return drawn_size_ >= kLeastShareOfWanted * options_.samples || !may_grow_;
}

// Whether the set's surfaces may be in the view: its camera has moved, more of it was made, or only
// the sky's shape is another. Under another sun other places are lit, and the set would not be
// balanced.
bool FollowedSamples::CanFollow(const SurfaceView& view) const {
  const bool is_other_sky_alone =
      view.sky_id != sky_id_ && view.sun_id == sun_id_ && !set_.IsShortOfUsablePixels();
  return drawn_ && (view.geometry_id != geometry_id_ || is_other_sky_alone) &&
         view.camera.intrinsics == camera_.intrinsics;
}

int FollowedSamples::FollowIn(const LightingObservation& observation, SampleSet& set) const {
  const Frame& frame = observation.frame;
  return set.Follow(
      observation.view, observation.sun.direction_enu, frame.radiance, frame.unusable, options_);
}

// Draws the set for this view; what of the last one it can follow stays.
void FollowedSamples::Draw(const LightingObservation& observation) {
  const Frame& frame = observation.frame;
  const glm::dvec3& sun = observation.sun.direction_enu;
  if (CanFollow(observation.view)) {
    const int kept = FollowIn(observation, set_);
    if (IsWorthFollowing() && kept >= kLeastShareOfKeptSet * drawn_size_) return;
    set_.Refill(observation.view, sun, frame.radiance, frame.unusable, options_);
    constexpr double kGrown = 1.25;
    may_grow_ = set_.Size() > kGrown * kept;
  } else {
    set_.Draw(observation.view, sun, frame.radiance, frame.unusable, options_);
    may_grow_ = true;
  }
  drawn_size_ = set_.Size();
  constexpr double kRemembered = 0.8;
  usual_size_ = std::max<double>(drawn_size_, kRemembered * usual_size_);
}

double FollowedSamples::Update(const LightingObservation& observation) {
  const Frame& frame = observation.frame;
  if (SetFits(observation.view)) {
    const int left_out =
        set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
    if (left_out <= (1.0 - kLeastShareOfKeptSet) * set_.Size()) return 0.0;
  }
  const auto start = std::chrono::steady_clock::now();
  Draw(observation);
  drawn_ = true;
  geometry_id_ = observation.view.geometry_id;
  sky_id_ = observation.view.sky_id;
  sun_id_ = observation.view.sun_id;
  camera_ = observation.view.camera;
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
  set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
  return spent.count();
}

}  // namespace pleinair
