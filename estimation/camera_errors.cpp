#include "estimation/camera_errors.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

namespace pleinair {
namespace {

// Standard deviations of the veil, as a share of the mean radiance of the picture. In order: linear
// frames; 8-bit frames with a stated exposure; a camera of which nothing is known. Assumed, not
// measured on cameras.
constexpr double kVeilOfLinear = 0.0005;
constexpr double kVeilOfStated = 0.005;
constexpr double kVeilOfUnknown = 0.015;
// Exponent of the response, of a camera that states its exposure and of one of which nothing is
// known. Real ones may have more (docs/weather.md); a wider deviation would explain faults of the
// mesh.
constexpr double kExponentOfStated = 0.02;
constexpr double kExponentOfUnknown = 0.05;
// Share of light that these lose in the corners, beyond what they correct themselves.
constexpr double kVignettingOfStated = 0.03;
constexpr double kVignettingOfUnknown = 0.1;
constexpr double kVignettingOfUnknownStddev = 0.1;
// Share by which colours are farther from grey. Cameras that choose their exposure mostly make them
// livelier, too.
constexpr double kSaturationOfStated = 0.03;
constexpr double kSaturationOfUnknown = 0.08;
constexpr double kSaturationOfUnknownStddev = 0.1;
// Share of a pattern's contrast that is lost where it lies beside its place.
constexpr double kPattern = 0.2;

// Over pixels on a raster: a veil need not be known better than by some per cent.
glm::dvec3 MeanRadiance(const RgbImage& radiance) {
  constexpr int kStep = 8;
  glm::dvec3 sum(0.0);
  double count = 0.0;
  for (int y = kStep / 2; y < radiance.height; y += kStep) {
    for (int x = kStep / 2; x < radiance.width; x += kStep) {
      const glm::dvec3 value(radiance.At(x, y));
      if (!std::isfinite(value.x + value.y + value.z)) continue;
      sum += glm::max(value, glm::dvec3(0.0));
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : sum;
}

double InformationOf(const LearnedError& error) { return 1.0 / (error.stddev * error.stddev); }

}  // namespace

CameraErrors ExpectedCameraErrors(const Frame& frame) {
  const bool is_unknown = frame.units == LightUnits::kRelativePerFrame;
  CameraErrors errors;
  errors.mean_radiance_rgb = MeanRadiance(frame.radiance);
  errors.veil_stddev = !frame.codes ? kVeilOfLinear : is_unknown ? kVeilOfUnknown : kVeilOfStated;
  if (frame.codes) {
    errors.exponent_stddev = is_unknown ? kExponentOfUnknown : kExponentOfStated;
    if (frame.exposure && *frame.exposure > 0.0) errors.white_radiance = 1.0 / *frame.exposure;
    errors.pattern_stddev = kPattern;
    errors.vignetting = is_unknown ? kVignettingOfUnknown : 0.0;
    errors.vignetting_stddev = is_unknown ? kVignettingOfUnknownStddev : kVignettingOfStated;
    errors.saturation = is_unknown ? kSaturationOfUnknown : 0.0;
    errors.saturation_stddev = is_unknown ? kSaturationOfUnknownStddev : kSaturationOfStated;
    errors.lens_circle =
        LensCircle::Of(frame.camera.intrinsics.width_px, frame.camera.intrinsics.height_px);
  }
  return errors;
}

ResponseCorrection CorrectionOf(const CameraErrors& camera,
                                const LightingFit& fit,
                                const glm::dvec3& unit_rgb) {
  ResponseCorrection correction{
      .white_radiance = camera.white_radiance,
      .unit_rgb = unit_rgb,
      .vignetting = std::clamp(fit.vignetting, 0.0, kMostVignetting),
      .saturation = std::clamp(fit.saturation, kLeastSaturation, kMostSaturation),
      .exponent = std::clamp(fit.exponent, -kMostResponseExponent, kMostResponseExponent)};
  // Before saturation and exponent, as light is.
  const double white = camera.white_radiance;
  const glm::dvec3 mean = glm::max(camera.mean_radiance_rgb / white, glm::dvec3(0.0));
  const glm::dvec3 seen = Desaturated(glm::pow(mean, glm::dvec3(1.0 / (1.0 + correction.exponent))),
                                      correction.saturation);
  correction.veil_rgb = std::max(fit.veil, 0.0) * white * glm::max(seen, glm::dvec3(0.0));
  return correction;
}

LearnedError WithEvidence(const LearnedError& known,
                          const LearnedError& expected,
                          const LearnedError& found,
                          double part) {
  if (!(known.stddev > 0.0) || !(expected.stddev > 0.0) || !(found.stddev > 0.0)) return known;
  const double of_known = InformationOf(known);
  const double of_expected = InformationOf(expected);
  const double of_found = InformationOf(found);
  if (!(of_found > of_expected)) return known;
  const double information = of_known + part * (of_found - of_expected);
  const double weighted =
      of_known * known.value + part * (of_found * found.value - of_expected * expected.value);
  // Errors of albedo that depend on brightness look like a response, the same in every frame.
  constexpr double kLeastStddev = 0.005;
  return {weighted / information, std::max(1.0 / std::sqrt(information), kLeastStddev)};
}

LearnedError WithEvidenceDownTo(double least_stddev,
                                const LearnedError& known,
                                const LearnedError& found,
                                double part) {
  if (!(known.stddev > least_stddev) || !(found.stddev > 0.0)) return known;
  const double wanted = InformationOf({0.0, least_stddev}) - InformationOf(known);
  const double offered = InformationOf(found) - InformationOf(known);
  if (offered > 0.0) part = std::min(part, wanted / offered);
  return WithEvidence(known, known, found, part);
}

}  // namespace pleinair
