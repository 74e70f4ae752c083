#include "estimation/outdoor_lighting_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimation/exposure_change.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"
#include "estimation/relative_prior.h"
#include "estimation/rough_light.h"
#include "estimation/sample_noise.h"
#include "estimation/sample_selection.h"

namespace pleinair {
namespace {

// Of a set that was drawn for an earlier frame; with fewer left, the frame gets its own.
constexpr double kLeastShareOfKeptSet = 0.8;

// A frame as much later is likely to show the same light.
constexpr auto kStartsAtTheLast = std::chrono::seconds(10);

bool AnyOfTheDiscIsUp(const LightingObservation& observation) {
  return observation.sun.direction_enu.z > -std::sin(observation.sun.angular_radius_rad);
}

// An earlier answer in the units of a picture that is brighter by `factor_rgb`.
void Rescale(const glm::dvec3& factor_rgb, CarriedLighting& carried) {
  for (Eigen::Index u = 0; u < carried.mean.size(); ++u) {
    carried.mean[u] *= factor_rgb[static_cast<int>(u % 3)];
    for (Eigen::Index v = 0; v < carried.mean.size(); ++v) {
      carried.covariance(u, v) *=
          factor_rgb[static_cast<int>(u % 3)] * factor_rgb[static_cast<int>(v % 3)];
    }
  }
}

double SkyOf(const LightVector& irradiance_rgb, int channel) {
  double sum = 0.0;
  for (Eigen::Index u = 3 + channel; u < irradiance_rgb.size(); u += 3) sum += irradiance_rgb[u];
  return sum;
}

// The clear-sky beam in the frame's units, mean over RGB. Where nothing is known of it, all the
// light there is.
double BeamOf(const ClearSkyExpectation& clear_sky, const LightVector& irradiance_rgb) {
  double beam = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double sky = SkyOf(irradiance_rgb, c);
    if (clear_sky.absolute) {
      beam += clear_sky.beam_rgb[c];
    } else if (clear_sky.diffuse_rgb[c] > 0.0) {
      beam += clear_sky.beam_rgb[c] / clear_sky.diffuse_rgb[c] * sky;
    } else {
      beam += irradiance_rgb[c] + sky;
    }
  }
  return beam / 3.0;
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
      : options_(options), fitter_(FitOptionsFor(options)) {
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

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    LightingEstimate estimate;
    estimate.new_sample_set_ms = UpdateSamples(observation);
    if (const Frame& frame = observation.frame; frame.noise != nullptr) {
      ApplySignalNoise(*frame.noise, frame.exposure.value_or(1.0), samples_);
    }

    const int sky_shapes = static_cast<int>(observation.view.sky_response.size());
    const bool sun_is_up = AnyOfTheDiscIsUp(observation);
    ClearSkyExpectation clear_sky = observation.clear_sky;
    estimate.units = observation.frame.units;
    // The survey's units are not the picture's: only the clear sky's sun-to-sky ratio holds.
    if (estimate.units != LightUnits::kAbsolute) clear_sky.absolute = false;
    if (estimate.units == LightUnits::kRelativePerFrame) {
      estimate.exposure_change = exposure_watch_.Compare(observation.frame, observation.view);
      CarryOverExposureChange(estimate.exposure_change);
    }
    const std::optional<CarriedLighting> earlier = LastAnswer(observation, sky_shapes);
    const auto prior_with = [&](double kept) {
      LightingPrior prior =
          MakeLightingPrior(clear_sky, earlier, observation.frame.time, sky_shapes, kept);
      SetBeamShape(observation.view.sky_shape_names, clear_sky, prior);
      if (!clear_sky.absolute) UseRelativeClearSky(FindRoughLight(samples_), prior);
      if (observation.held) {
        HoldIrradiance(observation.held->sun_rgb, observation.held->sky_rgb, prior);
      }
      return prior;
    };
    const LightingPrior prior = prior_with(1.0);
    // Of two starts a wrong model may favour either: a recording's frames, minutes apart, are each
    // found by themselves.
    const auto since = last_time_ ? observation.frame.time - *last_time_ : UtcTime::duration::max();
    if (since < UtcTime::duration::zero() || since > kStartsAtTheLast) fitter_.Forget();
    last_time_ = observation.frame.time;
    LightingFit fit = fitter_.Fit(samples_, prior, sun_is_up);
    // A cloud that moves the light in spite of the carried answer would move it all the way.
    const double kept =
        earlier ? KeptMemory(clear_sky, *earlier, observation.frame.time, fit.irradiance_rgb) : 1.0;
    if (kept < 1.0) fit = fitter_.Fit(samples_, prior_with(kept), sun_is_up);
    if (fit.samples_used == 0 && !prior.SaysSomething()) {
      return tl::unexpected(LightingFailure{
          "no usable sample: " + std::to_string(set_.Size()) + " footprints drawn, " +
          std::to_string(set_.Size() - static_cast<int>(samples_.size())) +
          " of them unusable in this frame; expected at least one, or a clear-sky light with a "
          "survey's units to fall back on"});
    }
    Describe(observation, clear_sky, fit, sun_is_up, estimate);
    if (sun_is_up) {
      carried_ = CarryForward(clear_sky,
                              earlier,
                              observation.frame.time,
                              fit.irradiance_rgb,
                              fit.data_information,
                              kept);
    } else {
      carried_.reset();
    }
    return estimate;
  }

 private:
  OutdoorLightingOptions options_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  glm::dvec3 basis_sun_enu_{0.0};  // What those that turn were made for.
  SampleSet set_;
  std::vector<DiffuseSample> samples_;
  LightingFitter fitter_;
  std::optional<CarriedLighting> carried_;
  std::optional<UtcTime> last_time_;
  ExposureWatch exposure_watch_;
  // What the set was drawn for.
  bool drawn_ = false;
  std::uint64_t geometry_version_ = 0;
  std::uint64_t sky_version_ = 0;
  std::uint64_t sun_version_ = 0;
  Camera camera_;

  bool SetFits(const SurfaceView& view) const {
    return drawn_ && !set_.IsShortOfUsablePixels() && view.geometry_version == geometry_version_ &&
           view.sky_version == sky_version_ && view.sun_version == sun_version_ &&
           view.camera == camera_;
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
    set_.Draw(observation.view,
              observation.sun.direction_enu,
              frame.radiance,
              frame.unusable,
              {options_.samples, options_.seed, options_.choice});
    drawn_ = true;
    geometry_version_ = observation.view.geometry_version;
    sky_version_ = observation.view.sky_version;
    sun_version_ = observation.view.sun_version;
    camera_ = observation.view.camera;
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
    return spent.count();
  }

  // The last frame's, or the survey's where that is nearer in time.
  std::optional<CarriedLighting> LastAnswer(const LightingObservation& observation,
                                            int sky_shapes) const {
    const Frame& frame = observation.frame;
    if (!observation.surveyed || frame.units != LightUnits::kAbsolute) return carried_;
    std::optional<CarriedLighting> survey =
        CarryFromSurvey(*observation.surveyed, frame.time, sky_shapes);
    if (!survey) return carried_;
    if (carried_ && carried_->time <= frame.time && carried_->time >= survey->time) return carried_;
    return survey;
  }

  // Where the picture tells what the exposure has done, the last answer goes on in its new units.
  void CarryOverExposureChange(const ExposureChange& change) {
    if (!carried_) return;
    if (change.kind == ExposureChange::Kind::kNone ||
        change.kind == ExposureChange::Kind::kExposure) {
      Rescale(change.factor_rgb, *carried_);
    } else {
      carried_.reset();
    }
  }

  static void Describe(const LightingObservation& observation,
                       const ClearSkyExpectation& clear_sky,
                       const LightingFit& fit,
                       bool sun_is_up,
                       LightingEstimate& estimate) {
    Lighting& lighting = estimate.lighting;
    lighting.time = observation.frame.time;
    lighting.sun.direction_enu = observation.sun.direction_enu;
    lighting.sun.angular_radius_rad = observation.sun.angular_radius_rad;
    const LightVector& light = fit.irradiance_rgb;
    lighting.sun.irradiance_rgb = {light[0], light[1], light[2]};
    for (std::size_t k = 0; k < observation.view.sky_response.size(); ++k) {
      const auto first = static_cast<Eigen::Index>(3 * (1 + k));
      lighting.sky.push_back({observation.view.sky_shape_names.at(k),
                              {light[first], light[first + 1], light[first + 2]}});
    }
    // Light is what is seen over albedo: where all albedos are too high, all lights are too weak.
    const glm::dvec3& scale = observation.albedo_stddev_rgb;
    const Eigen::Index unknowns = light.size();
    for (Eigen::Index u = 0; u < unknowns; ++u) {
      for (Eigen::Index v = 0; v < unknowns; ++v) {
        const double shared =
            scale[static_cast<int>(u % 3)] * light[u] * scale[static_cast<int>(v % 3)] * light[v];
        lighting.covariance.push_back(fit.covariance(u, v) + shared);
      }
    }
    const double beam = BeamOf(clear_sky, light);
    estimate.sun_observable =
        sun_is_up && observation.sun.direction_enu.z > 0.0 && TellsTheSun(fit, beam);
    estimate.samples_used = fit.samples_used;
    estimate.inlier_fraction = fit.inlier_fraction;
    estimate.condition_number = fit.condition_number;
    estimate.relative_residual = fit.relative_residual;
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
