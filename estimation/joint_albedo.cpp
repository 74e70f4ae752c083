#include "estimation/joint_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "estimation/camera_errors.h"
#include "estimation/internal/square.h"
#include "scene/lighting.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::Square;

constexpr double kHuber = 1.5;
// Change of an albedo, relative: far below any of its errors.
constexpr double kAlbedoConverged = 1e-3;
// The suns whose colour counts, as a share of the strongest.
constexpr double kStrongSun = 0.5;
// Below this share of a frame's usual light a sample's own error is glare and bounces.
constexpr double kLeastLight = 0.05;

// Transport of basis light `basis` (0 is the sun).
double TransportOf(const DiffuseSample& sample, int basis, int channel) {
  return basis == 0 ? sample.sun_transport_rgb[channel]
                    : sample.sky_transport_rgb[static_cast<std::size_t>(basis - 1)][channel];
}

// A frame's evidence of ln albedo.
struct Reading {
  double log_albedo = 0.0;
  double variance = 0.0;
  double sky_share = 0.0;  // Of the frame's light.
};

class JointFit {
 public:
  JointFit(std::span<const AlbedoFrame> frames,
           std::span<const glm::dvec3> expected_albedo_rgb,
           const JointAlbedoOptions& options)
      : frames_(frames), expected_(expected_albedo_rgb), options_(options), fitter_(options.fit) {
    options.Validate();
    Check();
    found_.surface_albedo_rgb.assign(expected_.begin(), expected_.end());
    found_.surface_stddev_rgb.assign(expected_.size(), glm::dvec3(options.expected_stddev));
    found_.spot_albedo_rgb.resize(surface_of_spot_.size());
    SpreadToSpots();
    found_.lights.resize(frames_.size());
    light_.resize(frames_.size());
    cameras_.reserve(frames_.size());
    for (const AlbedoFrame& frame : frames_) cameras_.push_back(frame.prior.camera);
  }

  JointAlbedo Fit() {
    LearnResponse();
    while (found_.iterations < options_.max_iterations && !found_.converged) {
      FitLights();
      const std::vector<glm::dvec3> before = found_.surface_albedo_rgb;
      UpdateSurfaces();
      FixScale();
      UpdateSpots();
      double change = 0.0;
      for (std::size_t s = 0; s < before.size(); ++s) {
        for (int c = 0; c < 3; ++c) {
          change =
              std::max(change, std::abs(std::log(found_.surface_albedo_rgb[s][c] / before[s][c])));
        }
      }
      ++found_.iterations;
      found_.converged = change < kAlbedoConverged;
    }
    FitLights();
    return std::move(found_);
  }

 private:
  std::span<const AlbedoFrame> frames_;
  std::span<const glm::dvec3> expected_;
  const JointAlbedoOptions& options_;
  LightingFitter fitter_;
  JointAlbedo found_;
  std::vector<std::int32_t> surface_of_spot_;  // -1: unseen.
  std::vector<double> samples_of_surface_;
  std::vector<DiffuseSample> scratch_;
  std::vector<CameraErrors> cameras_;  // One a frame: expected, then as all frames show them.
  // One a sample, without the camera's errors.
  struct Light {
    glm::dvec3 radiance_rgb{0.0};
    glm::dvec3 relative_stddev_rgb{0.0};
  };
  std::vector<std::vector<Light>> light_;

  void Check() {
    samples_of_surface_.assign(expected_.size(), 0.0);
    std::size_t count = 0;
    for (const AlbedoFrame& frame : frames_) {
      for (const AlbedoSample& sample : frame.samples) {
        if (sample.surface < 0 || static_cast<std::size_t>(sample.surface) >= expected_.size()) {
          throw std::invalid_argument("AlbedoSample::surface is " + std::to_string(sample.surface) +
                                      ": expected less than the " +
                                      std::to_string(expected_.size()) + " albedos given");
        }
        if (sample.spot < 0) {
          throw std::invalid_argument("AlbedoSample::spot is " + std::to_string(sample.spot) +
                                      ": expected 0 or more");
        }
        const auto spot = static_cast<std::size_t>(sample.spot);
        if (spot >= surface_of_spot_.size()) surface_of_spot_.resize(spot + 1, -1);
        if (surface_of_spot_[spot] >= 0 && surface_of_spot_[spot] != sample.surface) {
          throw std::invalid_argument("AlbedoSample::spot " + std::to_string(sample.spot) +
                                      " is on two surfaces: expected one");
        }
        surface_of_spot_[spot] = sample.surface;
        samples_of_surface_[static_cast<std::size_t>(sample.surface)] += 1.0;
        ++count;
      }
    }
    if (count == 0) throw std::invalid_argument("no sample to find albedos from: expected some");
    for (std::size_t s = 0; s < expected_.size(); ++s) {
      for (int c = 0; c < 3; ++c) {
        if (!(expected_[s][c] > 0.0) || !(expected_[s][c] <= 1.0)) {
          throw std::invalid_argument("expected albedo of surface " + std::to_string(s) + " is " +
                                      std::to_string(expected_[s][c]) + ": expected one in (0, 1]");
        }
      }
    }
  }

  void SpreadToSpots() {
    for (std::size_t spot = 0; spot < surface_of_spot_.size(); ++spot) {
      if (surface_of_spot_[spot] < 0) continue;
      found_.spot_albedo_rgb[spot] =
          found_.surface_albedo_rgb[static_cast<std::size_t>(surface_of_spot_[spot])];
    }
  }

  // With albedos that are off by `albedo_stddev`, each plane's by itself.
  void FitLights(double albedo_stddev = 0.0) {
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      scratch_.clear();
      for (const AlbedoSample& sample : frames_[f].samples) {
        DiffuseSample& scaled = scratch_.emplace_back(sample.white);
        const glm::dvec3& albedo = found_.spot_albedo_rgb[static_cast<std::size_t>(sample.spot)];
        scaled.sun_transport_rgb *= albedo;
        for (glm::dvec3& sky : scaled.sky_transport_rgb) sky *= albedo;
      }
      // The frames are of other times.
      LightingPrior prior = frames_[f].prior;
      prior.camera = cameras_[f];
      prior.albedo_stddev = std::max(prior.albedo_stddev, albedo_stddev);
      found_.lights[f] = fitter_.Fit(scratch_, prior, frames_[f].sun_is_up, FitStart::kRobust);
      TurnIntoLight(f);
    }
  }

  void TurnIntoLight(std::size_t f) {
    const CameraErrors& camera = cameras_[f];
    const ResponseCorrection correction = CorrectionOf(camera, found_.lights[f], glm::dvec3(1.0));
    light_[f].clear();
    for (const AlbedoSample& sample : frames_[f].samples) {
      const DiffuseSample& white = sample.white;
      const glm::dvec2 place_px = glm::dvec2(white.pixel) + 0.5;
      Light& light = light_[f].emplace_back();
      light.radiance_rgb =
          LightOf(white.radiance_rgb, correction, camera.lens_circle.ShareOfCorner(place_px));
      // A veil adds no noise, but takes its part of what is recorded.
      const glm::dvec3 veiled = (light.radiance_rgb + correction.veil_rgb) / light.radiance_rgb;
      light.relative_stddev_rgb =
          veiled * white.radiance_stddev_rgb / white.radiance_rgb / (1.0 + correction.exponent);
    }
  }

  // One camera has one response. It is found under the expected albedos, each plane's off by
  // itself: under albedos that the pictures themselves gave, any response explains them.
  void LearnResponse() {
    const bool is_known = std::all_of(cameras_.begin(), cameras_.end(), [](const CameraErrors& it) {
      return !(it.exponent_stddev > 0.0) && !(it.vignetting_stddev > 0.0) &&
             !(it.saturation_stddev > 0.0);
    });
    if (is_known) return;
    FitLights(options_.expected_stddev);
    Hold(&CameraErrors::exponent,
         &CameraErrors::exponent_stddev,
         &LightingFit::exponent,
         &LightingFit::exponent_stddev,
         {-kMostResponseExponent, kMostResponseExponent});
    Hold(&CameraErrors::vignetting,
         &CameraErrors::vignetting_stddev,
         &LightingFit::vignetting,
         &LightingFit::vignetting_stddev,
         {0.0, kMostVignetting});
    Hold(&CameraErrors::saturation,
         &CameraErrors::saturation_stddev,
         &LightingFit::saturation,
         &LightingFit::saturation_stddev,
         {kLeastSaturation, kMostSaturation});
  }

  // At the mean over the frames that do not know it; what is expected of them counts once.
  void Hold(double CameraErrors::*value,
            double CameraErrors::*stddev,
            double LightingFit::*fitted,
            double LightingFit::*fitted_stddev,
            const std::array<double, 2>& range) {
    std::optional<LearnedError> known;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      const LearnedError expected{cameras_[f].*value, cameras_[f].*stddev};
      if (!(expected.stddev > 0.0)) continue;
      const LightingFit& fit = found_.lights[f];
      known =
          WithEvidence(known.value_or(expected), expected, {fit.*fitted, fit.*fitted_stddev}, 1.0);
    }
    if (!known) return;
    // With the deviation that it has, the albedos found would move it again; 0 would be no error.
    constexpr double kHeldStddev = 1e-3;
    for (CameraErrors& camera : cameras_) {
      if (!(camera.*stddev > 0.0)) continue;
      camera.*value = std::clamp(known->value, range[0], range[1]);
      camera.*stddev = kHeldStddev;
    }
  }

  // Albedo of one sample in its frame's light; none where too little light falls on it.
  bool Read(std::size_t frame, std::size_t index, int channel, Reading& reading) const {
    const AlbedoSample& sample = frames_[frame].samples[index];
    const LightingFit& light = found_.lights[frame];
    const auto lights = light.irradiance_rgb.size() / 3;
    double white = 0.0;
    double sky = 0.0;
    double variance = 0.0;
    double usual = 0.0;
    for (Eigen::Index a = 0; a < lights; ++a) {
      const double t = TransportOf(sample.white, static_cast<int>(a), channel);
      white += t * light.irradiance_rgb[3 * a + channel];
      if (a > 0) sky += t * light.irradiance_rgb[3 * a + channel];
      usual += light.irradiance_rgb[3 * a + channel] / std::numbers::pi;
      for (Eigen::Index b = 0; b < lights; ++b) {
        variance += t * TransportOf(sample.white, static_cast<int>(b), channel) *
                    light.covariance(3 * a + channel, 3 * b + channel);
      }
    }
    const Light& seen = light_[frame][index];
    const double radiance = seen.radiance_rgb[channel];
    if (!(white > kLeastLight * usual) || !(radiance > 0.0)) return false;
    reading.log_albedo = std::log(radiance / white);
    reading.sky_share = sky / white;
    reading.variance = variance / Square(white) + Square(seen.relative_stddev_rgb[channel]);
    return std::isfinite(reading.log_albedo) && std::isfinite(reading.variance);
  }

  // The error that all samples of a surface share in one frame, lit or shaded: a real sky is not of
  // the fitted shape. So sunlit samples determine an albedo best.
  double SharedVariance(double sky_share) const {
    return Square(options_.frame_error) + Square(options_.fit.sky_shape_error * sky_share);
  }

  // The surfaces' readings frame by frame, in the sun and in the shade, then their robust mean.
  void UpdateSurfaces() {
    struct Readings {
      std::vector<double> log_albedo;
      double variance = 0.0;
      double sky_share = 0.0;
    };
    const std::size_t surfaces = expected_.size();
    for (int c = 0; c < 3; ++c) {
      std::vector<std::vector<Reading>> of_surface(surfaces);
      for (std::size_t f = 0; f < frames_.size(); ++f) {
        std::vector<Readings> of(2 * surfaces);
        for (std::size_t i = 0; i < frames_[f].samples.size(); ++i) {
          const AlbedoSample& sample = frames_[f].samples[i];
          Reading reading;
          if (!Read(f, i, c, reading)) continue;
          const std::size_t lit = reading.sky_share < 0.5 ? 1 : 0;
          Readings& readings = of[2 * static_cast<std::size_t>(sample.surface) + lit];
          readings.log_albedo.push_back(reading.log_albedo);
          readings.variance += reading.variance;
          readings.sky_share += reading.sky_share;
        }
        for (std::size_t i = 0; i < of.size(); ++i) {
          if (of[i].log_albedo.empty()) continue;
          const double count = static_cast<double>(of[i].log_albedo.size());
          of_surface[i / 2].push_back({UpperMedianInPlace(of[i].log_albedo),
                                       SharedVariance(of[i].sky_share / count) +
                                           of[i].variance / count +
                                           Square(options_.spot_spread) / count});
        }
      }
      for (std::size_t s = 0; s < surfaces; ++s) {
        of_surface[s].push_back({std::log(expected_[s][c]), Square(options_.expected_stddev)});
        const Reading mean = RobustMean(of_surface[s]);
        found_.surface_albedo_rgb[s][c] = std::exp(mean.log_albedo);
        found_.surface_stddev_rgb[s][c] = std::sqrt(mean.variance);
      }
    }
  }

  static Reading RobustMean(const std::vector<Reading>& readings) {
    double mean = 0.0;
    double whole = 0.0;
    for (const Reading& reading : readings) {
      mean += reading.log_albedo / reading.variance;
      whole += 1.0 / reading.variance;
    }
    mean /= whole;
    constexpr int kPasses = 10;
    double variance = 1.0 / whole;
    for (int pass = 0; pass < kPasses; ++pass) {
      double sum = 0.0;
      double weights = 0.0;
      double squares = 0.0;
      for (const Reading& reading : readings) {
        const double z = std::abs(reading.log_albedo - mean) / std::sqrt(reading.variance);
        const double weight = std::min(1.0, kHuber / std::max(z, kHuber)) / reading.variance;
        sum += weight * reading.log_albedo;
        weights += weight;
        squares += weight * reading.variance * Square(z);
      }
      mean = sum / weights;
      const double degrees = std::max(1.0, static_cast<double>(readings.size()) - 1.0);
      variance = std::max(1.0, squares / degrees) / weights;
    }
    return {mean, variance};
  }

  void UpdateSpots() {
    SpreadToSpots();
    std::vector<glm::dvec3> sum(surface_of_spot_.size(), glm::dvec3(0.0));
    std::vector<glm::dvec3> weights(surface_of_spot_.size(),
                                    glm::dvec3(1.0 / Square(options_.spot_spread)));
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      for (std::size_t i = 0; i < frames_[f].samples.size(); ++i) {
        const AlbedoSample& sample = frames_[f].samples[i];
        const auto spot = static_cast<std::size_t>(sample.spot);
        for (int c = 0; c < 3; ++c) {
          Reading reading;
          if (!Read(f, i, c, reading)) continue;
          const double surface =
              std::log(found_.surface_albedo_rgb[static_cast<std::size_t>(sample.surface)][c]);
          const double deviation = reading.log_albedo - surface + log_factor_[c];
          // Things that pass by are no stains.
          const double error =
              reading.variance + SharedVariance(reading.sky_share) + Square(options_.spot_spread);
          const double weight =
              std::min(1.0, 2.0 * std::sqrt(error) / std::max(std::abs(deviation), 1e-9)) / error;
          sum[spot][c] += weight * deviation;
          weights[spot][c] += weight;
        }
      }
    }
    for (std::size_t spot = 0; spot < surface_of_spot_.size(); ++spot) {
      if (surface_of_spot_[spot] < 0) continue;
      for (int c = 0; c < 3; ++c) {
        found_.spot_albedo_rgb[spot][c] *= std::exp(sum[spot][c] / weights[spot][c]);
      }
    }
  }

  glm::dvec3 log_factor_{0.0};  // Factor of the last FixScale on all albedos.

  void FixScale() {
    glm::dvec3 mean(0.0);
    glm::dvec3 expected(0.0);
    for (std::size_t s = 0; s < expected_.size(); ++s) {
      mean += samples_of_surface_[s] * found_.surface_albedo_rgb[s];
      expected += samples_of_surface_[s] * expected_[s];
    }
    glm::dvec3 factor = expected / mean;
    const glm::dvec3 sun_over_beam = SunOverBeam();
    found_.colour_from_sun = MeanOf(sun_over_beam) > 0.0;
    if (found_.colour_from_sun) {
      // The suns' colour then is the beam's; the size is the mean over RGB.
      factor = sun_over_beam;
      factor *= MeanOf(expected) / MeanOf(mean * factor);
    }
    for (glm::dvec3& albedo : found_.surface_albedo_rgb) albedo *= factor;
    for (int c = 0; c < 3; ++c) log_factor_[c] = std::log(factor[c]);
  }

  // Per channel the median of sun over beam, each of mean 1, over the strongest suns that their
  // frames determine; black where there is none.
  glm::dvec3 SunOverBeam() const {
    double strongest = 0.0;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (IsTold(f)) strongest = std::max(strongest, SunOf(f));
    }
    glm::dvec3 colour(0.0);
    for (int c = 0; c < 3; ++c) {
      std::vector<double> ratios;
      for (std::size_t f = 0; f < frames_.size(); ++f) {
        if (!IsTold(f) || !(SunOf(f) > kStrongSun * strongest)) continue;
        const glm::dvec3 ratio = SunRgb(f) / frames_[f].clear_beam_rgb;
        ratios.push_back(ratio[c] / MeanOf(ratio));
      }
      if (ratios.empty()) return glm::dvec3(0.0);
      colour[c] = UpperMedianInPlace(ratios);
    }
    return colour;
  }

  glm::dvec3 SunRgb(std::size_t f) const {
    const LightVector& light = found_.lights[f].irradiance_rgb;
    return {light[0], light[1], light[2]};
  }
  double SunOf(std::size_t f) const { return MeanOf(SunRgb(f)); }

  // Whether the samples determine the sun to a tenth of itself, in each channel.
  bool IsTold(std::size_t f) const {
    const glm::dvec3& beam = frames_[f].clear_beam_rgb;
    if (!frames_[f].sun_is_up || !(std::min({beam.x, beam.y, beam.z}) > 0.0)) return false;
    constexpr double kTold = 0.2;
    const glm::dvec3 sun = SunRgb(f);
    for (int c = 0; c < 3; ++c) {
      if (!(found_.lights[f].sun_stddev_data_rgb[c] < kTold * sun[c])) return false;
    }
    return true;
  }
};

}  // namespace

void JointAlbedoOptions::Validate() const {
  const auto positive = [](const char* field, double value) {
    if (value > 0.0 && std::isfinite(value)) return;
    throw std::invalid_argument(std::string("JointAlbedoOptions::") + field + " is " +
                                std::to_string(value) + ": expected a number above 0");
  };
  positive("expected_stddev", expected_stddev);
  positive("frame_error", frame_error);
  positive("spot_spread", spot_spread);
  if (max_iterations < 1) {
    throw std::invalid_argument("JointAlbedoOptions::max_iterations is " +
                                std::to_string(max_iterations) + ": expected at least 1");
  }
  fit.Validate();
}

JointAlbedo FitAlbedoAndLight(std::span<const AlbedoFrame> frames,
                              std::span<const glm::dvec3> expected_albedo_rgb,
                              const JointAlbedoOptions& options) {
  return JointFit(frames, expected_albedo_rgb, options).Fit();
}

}  // namespace pleinair
