#include "relight/sky_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"
#include "sunmodel/sky_luminance.h"

namespace pleinair {
namespace {

class UniformSkyShape final : public SkyShape {
 public:
  std::string Name() const override { return "uniform"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    return glm::vec3(direction_enu.z > 0.0f ? std::numbers::inv_pi_v<float> : 0.0f);
  }
};

class OvercastSkyShape final : public SkyShape {
 public:
  std::string Name() const override { return "overcast"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    // The integral of (1 + 2 sin e) / 3 times sin e over the hemisphere.
    constexpr double kIrradiance = 7.0 * std::numbers::pi / 9.0;
    return glm::vec3(
        static_cast<float>(OvercastSkyLuminance(glm::dvec3(direction_enu)) / kIrradiance));
  }
};

// A table over the hemisphere's equal-area map to a disc, (x, y) / sqrt(1 + z): a look-up costs a
// square root, where the model itself costs six exponentials and an arc tangent.
class ClearSkyShape final : public SkyShape {
 public:
  explicit ClearSkyShape(const glm::dvec3& sun_direction_enu)
      : table_(kSide * kSide, glm::vec3(0.0f)) {
    const ClearSkyDistribution sky(sun_direction_enu);
    tbb::parallel_for(0, kSide, [&](int row) {
      for (int column = 0; column < kSide; ++column) {
        table_[Cell(row, column)] = glm::vec3(sky.Radiance(DirectionAtCell(row, column)));
      }
    });
    glm::dvec3 irradiance(0.0);
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        if (!InsideDisc(row, column)) continue;
        irradiance += DirectionAtCell(row, column).z * glm::dvec3(table_[Cell(row, column)]);
      }
    }
    irradiance *= kCellSolidAngle;
    for (glm::vec3& value : table_) value = glm::vec3(glm::dvec3(value) / irradiance);
  }
  std::string Name() const override { return "clear"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    if (!(direction_enu.z > 0.0f)) return glm::vec3(0.0f);
    const float scale = 0.5f * kSide / std::sqrt(1.0f + direction_enu.z);
    const auto cell = [&](float coordinate) {
      return std::clamp(static_cast<int>(0.5f * kSide + scale * coordinate), 0, kSide - 1);
    };
    return table_[Cell(cell(direction_enu.y), cell(direction_enu.x))];
  }

 private:
  static constexpr int kSide = 256;
  // The unit disc stands for the hemisphere.
  static constexpr double kCellSolidAngle = 2.0 * 4.0 / (double{kSide} * kSide);

  static std::size_t Cell(int row, int column) {
    return static_cast<std::size_t>(row * kSide + column);
  }
  static glm::dvec2 DiscPoint(int row, int column) {
    return {(column + 0.5) * 2.0 / kSide - 1.0, (row + 0.5) * 2.0 / kSide - 1.0};
  }
  static bool InsideDisc(int row, int column) {
    const glm::dvec2 point = DiscPoint(row, column);
    return glm::dot(point, point) < 1.0;
  }
  // Cells on the rim whose centre is outside stand for the horizon next to them.
  static glm::dvec3 DirectionAtCell(int row, int column) {
    const glm::dvec2 point = DiscPoint(row, column);
    const double radius_squared = glm::dot(point, point);
    constexpr double kLeastSine = 0.5 / kSide;
    const double z = std::max(1.0 - radius_squared, kLeastSine);
    const double level = std::sqrt((1.0 - z * z) / radius_squared);
    return {level * point.x, level * point.y, z};
  }

  std::vector<glm::vec3> table_;
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

std::shared_ptr<const SkyShape> MakeOvercastSkyShape() {
  return std::make_shared<OvercastSkyShape>();
}

std::shared_ptr<const SkyShape> MakeClearSkyShape(const glm::dvec3& sun_direction_enu) {
  return std::make_shared<ClearSkyShape>(sun_direction_enu);
}

std::string_view NameOf(SkyShapeKind kind) {
  switch (kind) {
    case SkyShapeKind::kUniform:
      return "uniform";
    case SkyShapeKind::kOvercast:
      return "overcast";
    case SkyShapeKind::kClear:
      return "clear";
  }
  return "";
}

bool TurnsWithTheSun(SkyShapeKind kind) { return kind == SkyShapeKind::kClear; }

std::shared_ptr<const SkyShape> MakeSkyShape(SkyShapeKind kind,
                                             const glm::dvec3& sun_direction_enu) {
  switch (kind) {
    case SkyShapeKind::kUniform:
      return MakeUniformSkyShape();
    case SkyShapeKind::kOvercast:
      return MakeOvercastSkyShape();
    case SkyShapeKind::kClear:
      return MakeClearSkyShape(sun_direction_enu);
  }
  throw std::invalid_argument("sky shape: no such kind");
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
