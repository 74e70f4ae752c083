#include "relight/sky_shape.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

class UniformSkyShape final : public SkyShape {
 public:
  std::string Name() const override { return "uniform"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    return glm::vec3(direction_enu.z > 0.0f ? std::numbers::inv_pi_v<float> : 0.0f);
  }
};

// Row y's centre is on or above the horizon.
bool IsSkyRow(int y, int height) { return 2 * y + 1 <= height; }

// The first row whose centre is below the horizon takes the last sky row's values, so that
// interpolation towards the horizon does not fade into the black below.
RgbImage ExtendedOverHorizon(const RgbImage& sky) {
  RgbImage extended(sky.width, sky.height);
  for (int y = 0; y < sky.height; ++y) {
    if (IsSkyRow(y, sky.height)) {
      for (int x = 0; x < sky.width; ++x) extended.At(x, y) = sky.At(x, y);
    } else {
      for (int x = 0; x < sky.width; ++x) extended.At(x, y) = extended.At(x, y - 1);
      break;
    }
  }
  return extended;
}

class ImageSkyShape final : public SkyShape {
 public:
  ImageSkyShape(std::string name, RgbImage unit_sky)
      : name_(std::move(name)), unit_sky_(std::move(unit_sky)) {}
  std::string Name() const override { return name_; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    if (!(direction_enu.z > 0.0f)) return glm::vec3(0.0f);
    return SampleLatLong(unit_sky_, glm::dvec3(direction_enu));
  }

 private:
  std::string name_;
  RgbImage unit_sky_;
};

// Interpolation within a row keeps the row's mean, so the integral of the interpolated image needs
// only the rows' means, interpolated in elevation.
glm::dvec3 IrradianceOfExtended(const RgbImage& extended) {
  const int height = extended.height;
  std::vector<glm::dvec3> row_mean(static_cast<std::size_t>(height), glm::dvec3(0.0));
  for (int y = 0; y < height; ++y) {
    glm::dvec3& mean = row_mean[static_cast<std::size_t>(y)];
    for (int x = 0; x < extended.width; ++x) mean += glm::dvec3(extended.At(x, y));
    mean /= extended.width;
  }
  // 16 steps a row: the midpoint rule's error of the interpolated rows is then below 1e-6 for the
  // images of a few rows and far below that for the usual ones.
  constexpr int kStepsPerRow = 16;
  const int steps = (kStepsPerRow * height) / 2;
  glm::dvec3 irradiance(0.0);
  for (int step = 0; step < steps; ++step) {
    const double v_upper = static_cast<double>(step) / kStepsPerRow;
    const double v_lower = static_cast<double>(step + 1) / kStepsPerRow;
    const double v = 0.5 * (v_upper + v_lower) - 0.5;
    const int upper = std::max(0, static_cast<int>(std::floor(v)));
    const int lower = std::min(upper + 1, height - 1);
    const double share = std::max(0.0, v - upper);
    // Integral of sin(e) cos(e) over the strip's elevations, all around.
    const double sin_upper = std::cos(std::numbers::pi * v_upper / height);
    const double sin_lower = std::cos(std::numbers::pi * v_lower / height);
    const double weight = std::numbers::pi * (sin_upper * sin_upper - sin_lower * sin_lower);
    irradiance += weight * ((1.0 - share) * row_mean[static_cast<std::size_t>(upper)] +
                            share * row_mean[static_cast<std::size_t>(lower)]);
  }
  return irradiance;
}

void CheckSkyImage(const RgbImage& sky) {
  if (sky.width < 1 || sky.height < 2) {
    throw std::invalid_argument("sky image of " + std::to_string(sky.width) + "x" +
                                std::to_string(sky.height) + ": expected at least 1x2 pixels");
  }
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const glm::vec3& value = sky.At(x, y);
      for (int channel = 0; channel < 3; ++channel) {
        if (!(value[channel] >= 0.0f) || !std::isfinite(value[channel])) {
          throw std::invalid_argument("sky image: pixel (" + std::to_string(x) + ", " +
                                      std::to_string(y) + ") channel " + std::to_string(channel) +
                                      " is " + std::to_string(value[channel]) +
                                      ": expected a finite radiance >= 0");
        }
      }
    }
  }
}

}  // namespace

std::shared_ptr<const SkyShape> MakeUniformSkyShape() {
  return std::make_shared<UniformSkyShape>();
}

std::shared_ptr<const SkyShape> MakeImageSkyShape(std::string name, const RgbImage& sky_radiance) {
  CheckSkyImage(sky_radiance);
  RgbImage unit_sky = ExtendedOverHorizon(sky_radiance);
  const glm::dvec3 irradiance = IrradianceOfExtended(unit_sky);
  glm::dvec3 scale(0.0);
  for (int channel = 0; channel < 3; ++channel) {
    if (irradiance[channel] > 0.0) scale[channel] = 1.0 / irradiance[channel];
  }
  for (glm::vec3& pixel : unit_sky.pixels) pixel = glm::vec3(scale * glm::dvec3(pixel));
  return std::make_shared<ImageSkyShape>(std::move(name), std::move(unit_sky));
}

glm::dvec3 HorizontalIrradiance(const RgbImage& sky_radiance) {
  CheckSkyImage(sky_radiance);
  return IrradianceOfExtended(ExtendedOverHorizon(sky_radiance));
}

}  // namespace pleinair
