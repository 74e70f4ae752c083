#include "estimation/fisheye_lighting_source.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimation/fisheye_sky.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"
#include "estimation/sample_noise.h"
#include "estimation/sample_selection.h"

namespace pleinair {
namespace {

// Of a sun whose picture contradicts where it is: one of the two is wrong, and with it the light
// that reaches the scene.
// A field of view stated as 120 or 220 for 180 deg makes 0.5 and 1.4 of it.
constexpr double kMisplacedError = 0.4;
// Relative errors of an HDR fish-eye picture's radiances: of its own response and vignetting, and
// of the tie of its colours to the frame's camera.
constexpr double kPhotometricError = 0.02;

class FisheyeLightingSource final : public LightingSource {
 public:
  FisheyeLightingSource(const FisheyeCamera& camera, const FisheyeLightingOptions& options)
      : options_(options), sky_(camera, options.regions, options.detail) {}

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    if (!frame.fisheye_radiance) {
      return tl::unexpected(LightingFailure{
          "it has no fish-eye picture: expected one, or another source of light (--source)"});
    }
    sky_.Read(*frame.fisheye_radiance, sun.direction_enu, sun.angular_radius_rad);
    basis_.assign(1, sky_.Shape());
    return SkyBasis(basis_);
  }

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    LightingEstimate estimate;
    Lighting& lighting = estimate.lighting;
    lighting.time = observation.frame.time;
    lighting.sun.direction_enu = observation.sun.direction_enu;
    lighting.sun.angular_radius_rad = observation.sun.angular_radius_rad;
    lighting.sky = {{basis_.front()->Name(), sky_.SkyIrradianceRgb()}};
    estimate.sky_radiance_rgb.assign(sky_.RegionRadiance().begin(), sky_.RegionRadiance().end());
    estimate.inlier_fraction = 1.0;
    estimate.condition_number = 1.0;

    glm::dvec3 sun_stddev_rgb = sky_.Sun().stddev_rgb;
    lighting.sun.irradiance_rgb = sky_.Sun().irradiance_rgb;
    estimate.sun_elsewhere_enu = sky_.Sun().elsewhere_enu;
    if (sky_.Sun().clipped) {
      sun_stddev_rgb = FitClippedSun(observation, estimate);
    } else {
      estimate.sun_observable = observation.sun.direction_enu.z > 0.0;
      const double relative = estimate.sun_elsewhere_enu ? kMisplacedError : kPhotometricError;
      const glm::dvec3 of_itself = relative * lighting.sun.irradiance_rgb;
      sun_stddev_rgb = glm::sqrt(sun_stddev_rgb * sun_stddev_rgb + of_itself * of_itself);
    }
    if (estimate.sun_elsewhere_enu) estimate.sun_observable = false;
    lighting.covariance.assign(36, 0.0);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto channel = static_cast<int>(c);
      const double sky_stddev = kPhotometricError * lighting.sky[0].irradiance_rgb[channel];
      lighting.covariance[c * 7] = sun_stddev_rgb[channel] * sun_stddev_rgb[channel];
      lighting.covariance[(3 + c) * 7] = sky_stddev * sky_stddev;
    }
    return estimate;
  }

 private:
  FisheyeLightingOptions options_;
  FisheyeSky sky_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  SampleSet set_;
  std::vector<DiffuseSample> samples_;
  LightingFitter fitter_{LightingFitOptions{}};

  // The sun from what the frame's camera sees, the sky held at what the fish-eye says and the sun
  // not below what of the disc it shows. Returns the sun's standard deviation.
  glm::dvec3 FitClippedSun(const LightingObservation& observation, LightingEstimate& estimate) {
    const Frame& frame = observation.frame;
    set_.Draw(observation.view,
              observation.sun.direction_enu,
              frame.radiance,
              frame.unusable,
              {options_.samples, options_.seed});
    set_.Measure(observation.sun.direction_enu, frame.radiance, frame.unusable, samples_);
    if (frame.noise != nullptr) {
      ApplySignalNoise(*frame.noise, frame.exposure.value_or(1.0), samples_);
    }
    LightingPrior prior = MakeClimatePrior(observation.clear_sky, 1);
    Lighting& lighting = estimate.lighting;
    const glm::dvec3& sky = lighting.sky[0].irradiance_rgb;
    for (int c = 0; c < 3; ++c) {
      const double stddev = kPhotometricError * sky[c];
      if (!(stddev > 0.0)) continue;
      prior.information(3 + c, 3 + c) += 1.0 / (stddev * stddev);
      prior.information_times_mean[3 + c] += sky[c] / (stddev * stddev);
    }
    // The samples are others from frame to frame.
    const LightingFit fit = fitter_.Fit(samples_, prior, true, FitStart::kRobust);
    MarkRejected(fit, samples_);
    glm::dvec3 stddev(0.0);
    double beam = 0.0;
    for (int c = 0; c < 3; ++c) {
      lighting.sun.irradiance_rgb[c] =
          std::max(fit.irradiance_rgb[c], lighting.sun.irradiance_rgb[c]);
      stddev[c] = std::sqrt(fit.covariance(c, c));
      beam += observation.clear_sky.absolute ? observation.clear_sky.beam_rgb[c] / 3.0
                                             : lighting.sun.irradiance_rgb[c] / 3.0;
    }
    estimate.samples_used = fit.samples_used;
    estimate.inlier_fraction = fit.inlier_fraction;
    estimate.condition_number = fit.condition_number;
    estimate.relative_residual = fit.relative_residual;
    estimate.sun_observable = observation.sun.direction_enu.z > 0.0 && DeterminesSun(fit, beam);
    return stddev;
  }
};

}  // namespace

void FisheyeLightingOptions::Validate() const { SampleSelectionOptions{samples, seed}.Validate(); }

std::unique_ptr<LightingSource> MakeFisheyeLightingSource(const FisheyeCamera& camera,
                                                          const FisheyeLightingOptions& options) {
  options.Validate();
  return std::make_unique<FisheyeLightingSource>(camera, options);
}

}  // namespace pleinair
