#include "estimation/fisheye_lighting_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "estimation/fisheye_sky.h"
#include "estimation/followed_samples.h"
#include "estimation/internal/square.h"
#include "estimation/light_component.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"
#include "estimation/picture_check.h"
#include "estimation/sample_selection.h"

namespace pleinair {
namespace {

using estimation_internal::Square;

// Of a sun whose picture contradicts where it is: one of the two is wrong, and with it the light
// that reaches the scene.
// A field of view stated as 120 or 220 for 180 deg makes 0.5 and 1.4 of it.
constexpr double kMisplacedError = 0.4;
// Relative errors of an HDR fish-eye picture's radiances: of its own response and vignetting, and
// of the tie of its colours to the frame's camera.
constexpr double kPhotometricError = 0.02;
// The same of a factor that is found on surfaces, whose albedos err.
constexpr double kFactorError = 0.1;
// Albedos of a room make the picture some per cent to a third brighter or darker than the light; a
// factor beyond this one, of a channel, is of other units, exposures or colours.
constexpr double kLeastFactor = 1.5;
// The same after a frame that was: the light does not hop between the two.
constexpr double kLeastFactorStill = 1.25;
// A light that is wrong by more than a factor scatters more.
constexpr double kMostScatterOfFactor = 1.5;
// The sun's patches are a third and less of what they should be, or three times and more, where the
// fish-eye picture has another sun: hidden, or of another time. Edges that a mesh misplaces by some
// centimetres make a half or double of a small patch.
constexpr double kAnotherSun = 3.0;
constexpr double kAnotherSunStill = 2.0;  // The same after a frame that had.

// Relative, of a sky in a picture that surfaces contradict: clouds over the sun change it by as
// much.
constexpr double kContradictedError = 0.5;
// A fit to the surfaces explains them better only if it leaves less than this share of the scatter:
// two free numbers leave some less of any.
constexpr double kLeftOfScatter = 0.7;

bool IsFarFromOne(double factor, double limit) { return factor > limit || factor * limit < 1.0; }

class FisheyeLightingSource final : public LightingSource {
 public:
  FisheyeLightingSource(const FisheyeCamera& camera, const FisheyeLightingOptions& options)
      : sky_(camera, options.regions, options.detail), samples_({options.samples, options.seed}) {}

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
    const bool is_day = observation.sun.direction_enu.z > 0.0;
    if (is_day && !(MeanOf(sky_.SkyIrradianceRgb()) > 0.0)) {
      return tl::unexpected(LightingFailure{
          "its fish-eye picture is black, with the sun above the horizon: expected the sky"});
    }
    const SkyCameraCheck before = std::exchange(last_, {});
    LightingEstimate estimate = EstimateOfSky(observation);
    estimate.units = observation.frame.units;
    estimate.new_sample_set_ms = samples_.Measure(observation);
    const bool is_dark = !(MeanOf(sky_.SkyIrradianceRgb() + sky_.Sun().irradiance_rgb) > 0.0);
    FromSky from_sky{sky_.Sun().irradiance_rgb, kPhotometricError};
    if (estimate.units != LightUnits::kAbsolute && !is_dark) {
      // The sky's own units are not those of the picture, for which the light is.
      const auto over = CompareWithPicture(samples_.Samples(), estimate.lighting);
      if (!over) {
        return tl::unexpected(LightingFailure{
            "the exposure of its picture is not known, and hardly any surface in view shows it: "
            "expected frames[].exposure"});
      }
      Scale(sky_.Sun().clipped ? over->shaded_ratio_rgb : over->ratio_rgb, estimate);
      // Shaded places have the clipped sun's light from others.
      from_sky = {glm::dvec3(0.0), kContradictedError};
    }
    if (sky_.Sun().clipped) {
      Fit(observation, from_sky, estimate);
    } else if (!is_dark) {
      last_ = before;
      CheckAgainstPicture(observation, estimate);
    }
    if (estimate.sun_elsewhere_enu) estimate.sun_observable = false;
    return estimate;
  }

 private:
  FisheyeSky sky_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  FollowedSamples samples_;
  LightingFitter fitter_{LightingFitOptions{}};
  SkyCameraCheck last_;  // Of the frame before, if it was checked.

  // As the fish-eye picture has it, in its own units.
  LightingEstimate EstimateOfSky(const LightingObservation& observation) const {
    LightingEstimate estimate;
    Lighting& lighting = estimate.lighting;
    lighting.time = observation.frame.time;
    lighting.sun.direction_enu = observation.sun.direction_enu;
    lighting.sun.angular_radius_rad = observation.sun.angular_radius_rad;
    lighting.sun.irradiance_rgb = sky_.Sun().irradiance_rgb;
    lighting.sky = {{basis_.front()->Name(), sky_.SkyIrradianceRgb()}};
    estimate.sky_radiance_rgb.assign(sky_.RegionRadiance().begin(), sky_.RegionRadiance().end());
    estimate.inlier_fraction = 1.0;
    estimate.condition_number = 1.0;
    estimate.sun_elsewhere_enu = sky_.Sun().elsewhere_enu;
    estimate.sun_observable = observation.sun.direction_enu.z > 0.0;
    const double of_sun = estimate.sun_elsewhere_enu ? kMisplacedError : kPhotometricError;
    lighting.covariance.assign(36, 0.0);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto channel = static_cast<int>(c);
      lighting.covariance[c * 7] = Square(sky_.Sun().stddev_rgb[channel]) +
                                   Square(of_sun * lighting.sun.irradiance_rgb[channel]);
      lighting.covariance[(3 + c) * 7] =
          Square(kPhotometricError * lighting.sky[0].irradiance_rgb[channel]);
    }
    return estimate;
  }

  // To the units of the frame's picture, as its surfaces show them.
  static void Scale(const glm::dvec3& factor_rgb, LightingEstimate& estimate) {
    Lighting& lighting = estimate.lighting;
    for (std::size_t u = 0; u < SideOf(lighting); ++u) {
      const double factor = factor_rgb[static_cast<int>(u % 3)];
      Component(lighting, u) *= factor;
      ScaleDeviations(u, factor, lighting);
    }
    for (glm::dvec3& region : estimate.sky_radiance_rgb) region *= factor_rgb;
    estimate.sky_camera.factor_rgb *= factor_rgb;
    AddErrorOfAlbedos(lighting);
  }

  // Of light that is measured on surfaces.
  static void AddErrorOfAlbedos(Lighting& lighting) {
    for (std::size_t u = 0; u < 6; ++u) {
      for (std::size_t v = u % 3; v < 6; v += 3) {
        lighting.covariance[u * 6 + v] +=
            Square(kFactorError) * Component(lighting, u) * Component(lighting, v);
      }
    }
    lighting.common_stddev_rgb = glm::dvec3(kFactorError);
  }

  // Replaces what is far off by what the picture's surfaces show.
  void CheckAgainstPicture(const LightingObservation& observation, LightingEstimate& estimate) {
    const std::span<DiffuseSample> samples = samples_.Samples();
    auto over = CompareWithPicture(samples, estimate.lighting);
    if (!over) {
      last_ = {};
      return;
    }
    const double sun_limit = last_.shows_another_sun ? kAnotherSunStill : kAnotherSun;
    bool shows_another_sun = false;
    if (IsFarFromOne(over->lit_over_others, sun_limit)) {
      // Shaded places lack the light of the sun's patches, or the units are others, too.
      const LightingEstimate of_sky = estimate;
      for (const glm::dvec3& factor_rgb : {glm::dvec3(1.0), over->shaded_ratio_rgb}) {
        LightingEstimate trial = of_sky;
        if (factor_rgb != glm::dvec3(1.0)) Scale(factor_rgb, trial);
        Fit(observation, {glm::dvec3(0.0), kContradictedError}, trial);
        const auto left = CompareWithPicture(samples, trial.lighting);
        if (!trial.sun_observable || !left) continue;
        if (!(left->scatter - 1.0 < kLeftOfScatter * (over->scatter - 1.0))) continue;
        estimate = std::move(trial);
        shows_another_sun = true;
        over = left;
      }
    }
    estimate.sky_camera.shows_another_sun = shows_another_sun;
    if (IsInOtherUnits(*over)) Scale(over->ratio_rgb, estimate);
    // A trial may have been scaled before; the sky that was fitted to another sun leaves it open.
    const bool was_scaled = estimate.units == LightUnits::kAbsolute &&
                            estimate.sky_camera.factor_rgb != glm::dvec3(1.0);
    estimate.sky_camera.is_in_other_units =
        was_scaled || (shows_another_sun && last_.is_in_other_units);
    last_ = estimate.sky_camera;
  }

  bool IsInOtherUnits(const PictureOverLight& over) const {
    const double limit = last_.is_in_other_units ? kLeastFactorStill : kLeastFactor;
    const glm::dvec3& factor = over.ratio_rgb;
    return over.scatter <= kMostScatterOfFactor &&
           (IsFarFromOne(factor.r, limit) || IsFarFromOne(factor.g, limit) ||
            IsFarFromOne(factor.b, limit));
  }

  // What a fit keeps of the sky's picture.
  struct FromSky {
    glm::dvec3 least_sun_rgb{0.0};
    double sky_error = kPhotometricError;  // Relative.
  };

  // The sun from what the frame's camera sees, and the sky as far as its error allows.
  void Fit(const LightingObservation& observation,
           const FromSky& from_sky,
           LightingEstimate& estimate) {
    Lighting& lighting = estimate.lighting;
    const glm::dvec3& factor = estimate.sky_camera.factor_rgb;
    ClearSkyExpectation clear_sky = observation.clear_sky;
    clear_sky.beam_rgb *= factor;
    clear_sky.diffuse_rgb *= factor;
    LightingPrior prior = MakeClimatePrior(clear_sky, 1);
    glm::dvec3& sky = lighting.sky[0].irradiance_rgb;
    for (int c = 0; c < 3; ++c) {
      const double stddev = from_sky.sky_error * sky[c];
      if (!(stddev > 0.0)) continue;
      prior.information(3 + c, 3 + c) += 1.0 / Square(stddev);
      prior.information_times_mean[3 + c] += sky[c] / Square(stddev);
    }
    // The view, and with it the light on a place, may be another one in each frame.
    const LightingFit fit = fitter_.Fit(samples_.Samples(), prior, true, FitStart::kRobust);
    double beam = 0.0;
    const glm::dvec3 sky_before = sky;
    for (int c = 0; c < 3; ++c) {
      double& sun = lighting.sun.irradiance_rgb[c];
      sun = std::max(fit.irradiance_rgb[c], factor[c] * from_sky.least_sun_rgb[c]);
      if (from_sky.sky_error > kPhotometricError) sky[c] = fit.irradiance_rgb[3 + c];
      beam += clear_sky.absolute ? clear_sky.beam_rgb[c] / 3.0 : sun / 3.0;
    }
    for (glm::dvec3& region : estimate.sky_radiance_rgb) {
      for (int c = 0; c < 3; ++c) region[c] *= sky_before[c] > 0.0 ? sky[c] / sky_before[c] : 1.0;
    }
    for (std::size_t u = 0; u < 6; ++u) {
      for (std::size_t v = 0; v < 6; ++v) {
        lighting.covariance[u * 6 + v] =
            fit.covariance(static_cast<Eigen::Index>(u), static_cast<Eigen::Index>(v));
      }
    }
    lighting.common_stddev_rgb = glm::dvec3(0.0);
    if (from_sky.sky_error > kPhotometricError) AddErrorOfAlbedos(lighting);
    estimate.samples_used = fit.samples_used;
    estimate.inlier_fraction = fit.inlier_fraction;
    estimate.condition_number = fit.condition_number;
    estimate.relative_residual = fit.relative_residual;
    estimate.sun_observable = observation.sun.direction_enu.z > 0.0 && DeterminesSun(fit, beam);
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
