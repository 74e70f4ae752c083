#include "estimation/outdoor_lighting_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimation/camera_errors.h"
#include "estimation/exposure_change.h"
#include "estimation/followed_samples.h"
#include "estimation/light_change.h"
#include "estimation/outdoor_estimator.h"
#include "estimation/texture_contrast.h"

namespace pleinair {
namespace {

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
      : options_(options),
        samples_({options.samples, options.seed, options.choice}),
        estimator_(FitOptionsFor(options)) {
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
    return samples_.PixelsLookedAt(camera);
  }

  bool IsServedBy(const LightingObservation& observation) const override {
    return samples_.IsServedBy(observation);
  }

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    const double new_sample_set_ms = samples_.Measure(observation);
    const std::span<DiffuseSample> samples = samples_.Samples();

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
      conditions.texture = texture_watch_.Look(observation.frame, observation.view.camera, samples);
    }
    conditions.held = observation.held;
    conditions.albedo_stddev_rgb = observation.albedo_stddev_rgb;
    conditions.plane_albedo_stddev = observation.plane_albedo_stddev;
    conditions.camera = ExpectedCameraErrors(observation.frame);
    auto estimate = estimator_.Estimate(samples, conditions);
    if (!estimate) {
      const int seen = static_cast<int>(samples.size());
      const auto unknown = std::count_if(samples.begin(), samples.end(), IsUnknown);
      if (samples_.Places() == 0) {
        estimate.error().reason += " (no place in view can be sampled)";
        return estimate;
      }
      estimate.error().reason += " (of " + std::to_string(samples_.Places()) + " places " +
                                 std::to_string(samples_.Places() - seen) +
                                 " are hidden or masked, and " + std::to_string(unknown) +
                                 " clipped, black or of a plane that mostly is)";
      return estimate;
    }
    estimate->light_change = light_change_watch_.Compare(samples, estimate->lighting);
    estimate->new_sample_set_ms = new_sample_set_ms;
    return estimate;
  }

  std::span<const DiffuseSample> Samples() const override { return samples_.Samples(); }

 private:
  OutdoorLightingOptions options_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  glm::dvec3 basis_sun_enu_{0.0};  // The sun that shapes which turn are for.
  FollowedSamples samples_;
  OutdoorEstimator estimator_;
  ExposureWatch exposure_watch_;
  LightChangeWatch light_change_watch_;
  TextureWatch texture_watch_;
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
