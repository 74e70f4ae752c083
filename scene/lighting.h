// The light of one moment: intensities of basis lights, and their uncertainty.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/utc_time.h"

namespace pleinair {

// Radii of the sun's disc vary by 1.7 % over the year; sunmodel gives the day's.
inline constexpr double kMeanSunAngularRadiusRad = 0.004654;

// Direction of a sun that is absent or unknown: below every horizon.
inline constexpr glm::dvec3 kNoSunDirectionEnu{0.0, 0.0, -1.0};

inline double MeanOf(const glm::dvec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0; }
inline float MeanOf(const glm::vec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0f; }

// A far light; its direction points towards it.
struct DirectionalLight {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};  // Unit.
  glm::dvec3 irradiance_rgb{0.0};           // Normal to the beam.
  double angular_radius_rad = kMeanSunAngularRadiusRad;
};

// One fixed function of direction over the upper hemisphere, and its intensity: irradiance_rgb is
// its irradiance on an unoccluded horizontal plane.
struct SkyComponent {
  std::string shape = "uniform";
  glm::dvec3 irradiance_rgb{0.0};
};

// The unit of light.
enum class LightUnits {
  kAbsolute,          // The survey's units; W m^-2 where these are.
  kRelative,          // One unknown factor for all frames.
  kRelativePerFrame,  // Exposure and white balance unknown: a factor for each channel and frame.
};

// As in files: absolute, relative, relative per frame.
const char* NameOf(LightUnits units);

// The light of one moment, in the world frame (ENU).
struct Lighting {
  UtcTime time{};
  DirectionalLight sun;           // Irradiance 0 where there is none.
  std::vector<SkyComponent> sky;  // In the order of the transport's sky basis.

  // Row-major square matrix over (sun RGB, sky[0] RGB, sky[1] RGB, ...) in irradiance units
  // squared; empty where the source does not know it.
  std::vector<double> covariance;
  // Relative standard deviation of a factor that all of it has in common, such as the albedos' that
  // it is measured on; in the covariance, too.
  glm::dvec3 common_stddev_rgb{0.0};

  glm::dvec3 SkyIrradianceRgb() const {
    glm::dvec3 sum(0.0);
    for (const SkyComponent& component : sky) sum += component.irradiance_rgb;
    return sum;
  }
};

// A mean over RGB, and its standard deviation from the covariance: 0 where there is none.
struct MeanIrradiance {
  double mean = 0.0;
  double stddev = 0.0;
};
MeanIrradiance MeanSunIrradiance(const Lighting& lighting);  // Normal to the beam.
MeanIrradiance MeanSkyIrradiance(const Lighting& lighting);  // Horizontal, of all components.

}  // namespace pleinair
