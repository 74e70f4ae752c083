#include "estimation/outdoor_lighting_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimation/camera_errors.h"
#include "estimation/exposure_change.h"
#include "estimation/light_change.h"
#include "estimation/outdoor_estimator.h"
#include "estimation/sample_noise.h"
#include "estimation/sample_selection.h"
#include "estimation/texture_contrast.h"
#include "scene/state_id.h"

namespace pleinair {
namespace {

// Least share of a set drawn for an earlier frame; with fewer samples left, the frame gets its own
// set.
constexpr double kLeastShareOfKeptSet = 0.8;
// The same of a set whose places lie in a new view: some of them will be occluded.
constexpr double kLeastShareInView = 0.85;

// Clipped or black in all channels, or of a plane that mostly is (ApplySignalNoise).
bool IsUnknown(const DiffuseSample& sample) {
  const glm::dvec3& stddev = sample.radiance_stddev_rgb;
  return std::isinf(stddev.x) && std::isinf(stddev.y) && std::isinf(stddev.z);
}

LightingFitOptions FitOptionsFor(const OutdoorLightingOptions& options) {
  LightingFitOptions fit = options.fit;
  if (options.sky_shapes.size() == 1) {
    fit.sky_shape_error = std::max(fit.sky_shape_error, kLoneSkyShapeError);
  }
  return fit;
}

class OutdoorLightingSource final : public LightingSource {
 public:
  explicit OutdoorLightingSource(const OutdoorLightingOptions& options)
      : options_(options), estimator_(FitOptionsFor(options)) {
    options.Validate();
  }

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame&, const SunState& sun) override {
    const bool first = basis_.empty();
    if (!first && sun.direction_enu == basis_sun_enu_) return SkyBasis(basis_);
    basis_.resize(options_.sky_shapes.size());
    for (std::size_t k = 0; k < basis_.size(); ++k) {
      const SkyShapeKind kind = options_.sky_shapes[k];
      if (first || TurnsWithTheSun(kind)) {
        basis_[k] = MakeSkyShape(kind, sun.direction_enu, options_.aerosol_optical_depth_500nm);
      }
    }
    basis_sun_enu_ = sun.direction_enu;
    return SkyBasis(basis_);
  }

  std::optional<std::vector<PixelRect>> PixelsLookedAt(const Camera& camera) const override {
    if (!IsWorthFollowing() || camera.intrinsics != camera_.intrinsics) return std::nullopt;
    std::vector<PixelRect> pixels = set_.PixelsFollowed(camera);
    if (static_cast<double>(pixels.size()) < kLeastShareInView * drawn_size_) return std::nullopt;
    return pixels;
  }

  bool IsServedBy(const LightingObservation& observation) const override {
    if (!SetFits(observation.view) && !CanFollow(observation.view)) return false;
    if (!IsWorthFollowing()) return false;
    SampleSet followed = set_;
    return FollowIn(observation, followed) >= kLeastShareOfKeptSet * drawn_size_;
  }

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    const double new_sample_set_ms = UpdateSamples(observation);
    if (const Frame& frame = observation.frame; frame.noise != nullptr) {
      ApplySignalNoise(*frame.noise, frame.exposure.value_or(1.0), samples_);
    }

    OutdoorConditions conditions;
    conditions.time = observation.frame.time;
    conditions.sun = observation.sun;
    conditions.clear_sky = observation.clear_sky;
    conditions.sky_shape_names = observation.view.sky_shape_names;
    conditions.units = observation.frame.units;
    if (conditions.units == LightUnits::kRelativePerFrame) {
      conditions.exposure_change = exposure_watch_.Compare(observation.frame, observation.view);
    }
    conditions.weather = observation.frame.weather;
    conditions.surveyed = observation.surveyed;
    if (!observation.surveyed) {
      conditions.texture =
          texture_watch_.Look(observation.frame, observation.view.camera, samples_);
    }
    conditions.held = observation.held;
    conditions.albedo_stddev_rgb = observation.albedo_stddev_rgb;
    conditions.plane_albedo_stddev = observation.plane_albedo_stddev;
    conditions.camera = ExpectedCameraErrors(observation.frame);
    auto estimate = estimator_.Estimate(samples_, conditions);
    if (!estimate) {
      const int seen = static_cast<int>(samples_.size());
      const auto unknown = std::count_if(samples_.begin(), samples_.end(), IsUnknown);
      if (set_.Size() == 0) {
        estimate.error().reason += " (no place in view can be sampled)";
        return estimate;
      }
      estimate.error().reason += " (of " + std::to_string(set_.Size()) + " places " +
                                 std::to_string(set_.Size() - seen) +
                                 " are hidden or masked, and " + std::to_string(unknown) +
                                 " clipped, black or of a plane that mostly is)";
      return estimate;
    }
    estimate->light_change = light_change_watch_.Look(samples_, estimate->lighting);
    estimate->new_sample_set_ms = new_sample_set_ms;
    return estimate;
  }

  std::span<const DiffuseSample> Samples() const override { return samples_; }

 private:
  OutdoorLightingOptions options_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  glm::dvec3 basis_sun_enu_{0.0};  // The sun that shapes which turn are for.
  SampleSet set_;
  std::vector<DiffuseSample> samples_;
  OutdoorEstimator estimator_;
  ExposureWatch exposure_watch_;
  LightChangeWatch light_change_watch_;
  TextureWatch texture_watch_;
  // The key of the set.
  bool drawn_ = false;
  int drawn_size_ = 0;       // Size of the set when it was last filled.
  double usual_size_ = 0.0;  // Of the last sets; the largest is forgotten over some.
  bool may_grow_ = true;     // Whether another view may show many more surfaces than the set has.
  StateId geometry_id_;
  StateId sky_id_;
  StateId sun_id_;
  Camera camera_;

  bool SetFits(const SurfaceView& view) const {
    return drawn_ && !set_.IsShortOfUsablePixels() && view.geometry_id.IsSet() &&
           view.geometry_id == geometry_id_ && view.sky_id == sky_id_ && view.sun_id == sun_id_ &&
           view.camera == camera_;
  }

  // A set of a view that showed hardly any surface is not enough for the next one, though all of it
  // may be found there again.
  bool IsWorthFollowing() const {
    constexpr double kLeastShareOfUsual = 0.5;
    constexpr double kLeastShareOfWanted = 0.1;
    if (!drawn_ || drawn_size_ == 0 || drawn_size_ < kLeastShareOfUsual * usual_size_) return false;
    return drawn_size_ >= kLeastShareOfWanted * options_.samples || !may_grow_;
  }

  // Whether the set's surfaces may be in the view: its camera has moved, or more of it was made.
  bool CanFollow(const SurfaceView& view) const {
    return drawn_ && view.geometry_id != geometry_id_ &&
           view.camera.intrinsics == camera_.intrinsics;
  }

  SampleSelectionOptions Selection() const {
    return {options_.samples, options_.seed, options_.choice};
  }

  int FollowIn(const LightingObservation& observation, SampleSet& set) const {
    const Frame& frame = observation.frame;
    return set.Follow(observation.view,
                      observation.sun.direction_enu,
                      frame.radiance,
                      frame.unusable,
                      Selection());
  }

  // Draws the set for this view; what of the last one it can follow stays.
  void DrawSamples(const LightingObservation& observation) {
    const Frame& frame = observation.frame;
    const glm::dvec3& sun = observation.sun.direction_enu;
    if (CanFollow(observation.view)) {
      const int kept = FollowIn(observation, set_);
      if (IsWorthFollowing() && kept >= kLeastShareOfKeptSet * drawn_size_) return;
      set_.Refill(observation.view, sun, frame.radiance, frame.unusable, Selection());
      constexpr double kGrown = 1.25;
      may_grow_ = set_.Size() > kGrown * kept;
    } else {
      set_.Draw(observation.view, sun, frame.radiance, frame.unusable, Selection());
      may_grow_ = true;
    }
    drawn_size_ = set_.Size();
    constexpr double kRemembered = 0.8;
    usual_size_ = std::max<double>(drawn_size_, kRemembered * usual_size_);
  }

  // Returns the time spent on drawing, in ms.
  double UpdateSamples(const LightingObservation& observation) {
    const Frame& frame = observation.frame;
    if (SetFits(observation.view)) {
      const int left_out =
          set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
      if (left_out <= (1.0 - kLeastShareOfKeptSet) * set_.Size()) return 0.0;
    }
    const auto start = std::chrono::steady_clock::now();
    DrawSamples(observation);
    drawn_ = true;
    geometry_id_ = observation.view.geometry_id;
    sky_id_ = observation.view.sky_id;
    sun_id_ = observation.view.sun_id;
    camera_ = observation.view.camera;
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
    return spent.count();
  }
};

}  // namespace

void OutdoorLightingOptions::Validate() const {
  SampleSelectionOptions{samples, seed, choice}.Validate();
  fit.Validate();
  if (sky_shapes.empty()) throw std::invalid_argument("sky_shapes: expected at least one");
  for (const SkyShapeKind kind : sky_shapes) {
    if (std::count(sky_shapes.begin(), sky_shapes.end(), kind) > 1) {
      throw std::invalid_argument("sky_shapes: " + std::string(NameOf(kind)) +
                                  " is there twice: expected once");
    }
  }
}

std::unique_ptr<LightingSource> MakeOutdoorLightingSource(const OutdoorLightingOptions& options) {
  return std::make_unique<OutdoorLightingSource>(options);
}

}  // namespace pleinair
