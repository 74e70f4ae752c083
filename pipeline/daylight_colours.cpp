#include "pipeline/daylight_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/light_component.h"
#include "sunmodel/refraction.h"

namespace pleinair {
namespace {

constexpr double kLeastSunOverSky = 0.02;  // A shadow of two code values.
constexpr double kRounding = 1e-9;

int LargestChannel(const glm::dvec3& rgb) {
  if (rgb.x >= rgb.y && rgb.x >= rgb.z) return 0;
  return rgb.y >= rgb.z ? 1 : 2;
}

double MostRise(const glm::dvec3& to_sun) {
  constexpr double kAirMassAt30Deg = 2.0;
  const double elevation_rad = std::asin(std::clamp(to_sun.z, 0.0, 1.0));
  const double beyond = RelativeAirMass(elevation_rad) - kAirMassAt30Deg;
  return kMostRiseOfSkyOverSun * std::exp(kMoreRisePerAirMass * std::max(beyond, 0.0));
}

// Sky over sun of channel `high` is at most `most` times that of `low`.
struct ColourBound {
  int high = 0;
  int low = 0;
  double most = 1.0;
};

// Returns whether it held. No channel of the sky is 0.
bool Hold(const ColourBound& bound, glm::dvec3& sun, glm::dvec3& sky) {
  const auto& [high, low, most] = bound;
  const double least_sun = sky[high] / sky[low] * sun[low] / most;
  if (!(least_sun > (1.0 + kRounding) * sun[high])) return true;
  const double least_sky =
      sun[high] > 0.0 ? least_sun / sun[high] * sky[low] : std::numeric_limits<double>::infinity();
  if (least_sky - sky[low] < least_sun - sun[high]) {
    sky[low] = least_sky;
  } else {
    sun[high] = least_sun;
  }
  return false;
}

// Green over the geometric mean of red and blue that `rgb` has to have. `first` to `end` are its
// rows of the covariance.
double LeastGreen(const Lighting& lighting,
                  const glm::dvec3& rgb,
                  std::size_t first,
                  std::size_t end) {
  const std::size_t side = SideOf(lighting);
  const double green = rgb.g / std::sqrt(rgb.r * rgb.b);
  if (!HasCovariance(lighting) || !(green > 0.0) || !std::isfinite(green)) {
    return kLeastGreen;
  }
  // Derivative of the logarithm.
  const glm::dvec3 slope = glm::dvec3(-0.5, 1.0, -0.5) / rgb;
  double variance = 0.0;
  for (std::size_t a = first; a < end; ++a) {
    for (std::size_t b = first; b < end; ++b) {
      variance += slope[static_cast<int>(a % 3)] * slope[static_cast<int>(b % 3)] *
                  lighting.covariance[a * side + b];
    }
  }
  if (!std::isfinite(variance)) return kLeastGreen;
  variance = std::max(variance, 0.0);  // Rounding, where only what is common to all is not known.
  const double weight = variance / (variance + kGreenLogStddev * kGreenLogStddev);
  const double mean = green * std::pow(kUsualGreen / green, weight);
  return std::clamp(mean, kLeastGreenOfAnyCamera, kLeastGreen);
}

// Returns whether it held.
bool HoldGreen(double least_green, glm::dvec3& rgb) {
  const double least = least_green * std::sqrt(rgb.r * rgb.b);
  if (!(least > (1.0 + kRounding) * rgb.g)) return true;
  rgb.g = least;
  return false;
}

struct GreenLimits {
  double sun = kLeastGreen;
  double sky = kLeastGreen;
};

// Each fix may undo another one, and what it adds grows until the other light's is less.
void HoldSkyOverSun(const glm::dvec3& to_sun,
                    const GreenLimits& least_green,
                    glm::dvec3& sun,
                    glm::dvec3& sky) {
  if (!(sun[LargestChannel(sun)] > kLeastSunOverSky * sky[LargestChannel(sky)])) return;
  if (!(std::min({sky.x, sky.y, sky.z}) > 0.0)) return;
  const double most = MostRise(to_sun);
  const ColourBound bounds[] = {{0, 1, 1.0 / kLeastRiseOfSkyOverSun},
                                {1, 2, 1.0 / kLeastRiseOfSkyOverSun},
                                {2, 1, most},
                                {1, 0, most}};
  constexpr int kPasses = 100;
  for (int pass = 0; pass < kPasses; ++pass) {
    bool all_hold = HoldGreen(least_green.sun, sun);
    all_hold = HoldGreen(least_green.sky, sky) && all_hold;
    for (const ColourBound& bound : bounds) all_hold = Hold(bound, sun, sky) && all_hold;
    if (all_hold) return;
  }
}

// What has been made brighter is uncertain by the same share.
void KeepRelativeDeviations(const Lighting& before, Lighting& lighting) {
  for (std::size_t u = 0; u < SideOf(lighting); ++u) {
    const double was = Component(before, u);
    if (was > 0.0) ScaleDeviations(u, Component(lighting, u) / was, lighting);
  }
}

}  // namespace

std::optional<Lighting> WithDaylightColours(const Lighting& lighting) {
  Lighting coloured;
  coloured.sky = lighting.sky;
  const glm::dvec3 given = lighting.SkyIrradianceRgb();
  const int largest = LargestChannel(given);
  for (int c = 0; c < 3; ++c) {
    if (given[c] >= kLeastSkyChannel * given[largest]) continue;
    for (SkyComponent& component : coloured.sky) {
      component.irradiance_rgb[c] = kLeastSkyChannel * component.irradiance_rgb[largest];
    }
  }
  const glm::dvec3 raised = coloured.SkyIrradianceRgb();
  glm::dvec3 sky = raised;
  glm::dvec3 sun = lighting.sun.irradiance_rgb;
  const GreenLimits least_green{LeastGreen(lighting, sun, 0, 3),
                                LeastGreen(lighting, given, 3, SideOf(lighting))};
  HoldGreen(least_green.sky, sky);
  HoldSkyOverSun(lighting.sun.direction_enu, least_green, sun, sky);
  if (sky == given && sun == lighting.sun.irradiance_rgb) return std::nullopt;
  if (sky != raised) {
    for (SkyComponent& component : coloured.sky) component.irradiance_rgb *= sky / raised;
  }
  coloured.time = lighting.time;
  coloured.sun = lighting.sun;
  coloured.sun.irradiance_rgb = sun;
  coloured.covariance = lighting.covariance;
  KeepRelativeDeviations(lighting, coloured);
  coloured.common_stddev_rgb = lighting.common_stddev_rgb;
  return coloured;
}

}  // namespace pleinair
