#include "scene/sky_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

class UniformSkyShape final : public SkyShape {
 public:
  std::string Name() const override { return "uniform"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    return glm::vec3(direction_enu.z > 0.0f ? std::numbers::inv_pi_v<float> : 0.0f);
  }
  std::optional<ByHeight> LinearInHeight() const override {
    return ByHeight{double{std::numbers::inv_pi_v<float>}, 0.0};
  }
};

class TableSkyShape final : public SkyShape {
 public:
  TableSkyShape(std::string name, std::vector<glm::vec3> table)
      : name_(std::move(name)), table_(std::move(table)) {}
  std::string Name() const override { return name_; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    if (!(direction_enu.z > 0.0f)) return glm::vec3(0.0f);
    return table_[SkyTable::CellOf(direction_enu)];
  }
  const std::vector<glm::vec3>* Table() const override { return &table_; }

 private:
  std::string name_;
  std::vector<glm::vec3> table_;
};

glm::dvec2 DiscPoint(std::size_t cell) {
  const std::size_t column = cell % SkyTable::kSide;
  const std::size_t row = cell / SkyTable::kSide;
  return {(static_cast<double>(column) + 0.5) * 2.0 / SkyTable::kSide - 1.0,
          (static_cast<double>(row) + 0.5) * 2.0 / SkyTable::kSide - 1.0};
}

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

// 0 for a channel without light.
glm::vec3 InverseOf(const glm::dvec3& irradiance) {
  glm::dvec3 inverse(0.0);
  for (int channel = 0; channel < 3; ++channel) {
    if (irradiance[channel] > 0.0) inverse[channel] = 1.0 / irradiance[channel];
  }
  return glm::vec3(inverse);
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

// (x, y) / sqrt(1 + z) maps the upper hemisphere to the unit disc, equal areas to equal ones.
glm::dvec3 SkyTable::DirectionOfCell(std::size_t cell) {
  const glm::dvec2 point = DiscPoint(cell);
  const double radius_squared = glm::dot(point, point);
  constexpr double kLeastSine = 0.5 / kSide;
  const double z = std::max(1.0 - radius_squared, kLeastSine);
  const double level = std::sqrt((1.0 - z * z) / radius_squared);
  return {level * point.x, level * point.y, z};
}

double SkyTable::SolidAngleSr(std::size_t cell) {
  const glm::dvec2 point = DiscPoint(cell);
  // The disc's area of pi represents 2 pi steradians.
  return glm::dot(point, point) < 1.0 ? 2.0 * 4.0 / static_cast<double>(kCells) : 0.0;
}

std::size_t SkyTable::CellOf(const glm::vec3& direction_enu) {
  const float scale = 0.5f * kSide / std::sqrt(1.0f + direction_enu.z);
  const auto index = [&](float coordinate) {
    return static_cast<std::size_t>(
        std::clamp(static_cast<int>(0.5f * kSide + scale * coordinate), 0, kSide - 1));
  };
  return index(direction_enu.y) * kSide + index(direction_enu.x);
}

glm::dvec3 HorizontalIrradiance(std::span<const glm::vec3> table) {
  if (table.size() != SkyTable::kCells) {
    throw std::invalid_argument(std::string("sky table of ") + std::to_string(table.size()) +
                                " cells: expected " + std::to_string(SkyTable::kCells));
  }
  static const std::vector<double> weights = [] {
    std::vector<double> projected_sr;
    for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
      projected_sr.push_back(SkyTable::SolidAngleSr(cell) * SkyTable::DirectionOfCell(cell).z);
    }
    return projected_sr;
  }();
  glm::dvec3 irradiance(0.0);
  for (std::size_t cell = 0; cell < table.size(); ++cell) {
    const glm::vec3& value = table[cell];
    for (int channel = 0; channel < 3; ++channel) {
      if (!(value[channel] >= 0.0f) || !std::isfinite(value[channel])) {
        throw std::invalid_argument(std::string("sky table: cell ") + std::to_string(cell) +
                                    " channel " + std::to_string(channel) + " is " +
                                    std::to_string(value[channel]) +
                                    ": expected a finite radiance >= 0");
      }
    }
    irradiance += weights[cell] * glm::dvec3(value);
  }
  return irradiance;
}

std::shared_ptr<const SkyShape> MakeTableSkyShape(std::string name,
                                                  std::vector<glm::vec3> radiance) {
  const glm::vec3 scale = InverseOf(HorizontalIrradiance(radiance));
  for (glm::vec3& value : radiance) value *= scale;
  return std::make_shared<TableSkyShape>(std::move(name), std::move(radiance));
}

std::shared_ptr<const SkyShape> MakeImageSkyShape(std::string name, const RgbImage& sky_radiance) {
  CheckSkyImage(sky_radiance);
  RgbImage unit_sky = ExtendedOverHorizon(sky_radiance);
  const glm::vec3 scale = InverseOf(IrradianceOfExtended(unit_sky));
  for (glm::vec3& pixel : unit_sky.pixels) pixel *= scale;
  return std::make_shared<ImageSkyShape>(std::move(name), std::move(unit_sky));
}

glm::dvec3 HorizontalIrradiance(const RgbImage& sky_radiance) {
  CheckSkyImage(sky_radiance);
  return IrradianceOfExtended(ExtendedOverHorizon(sky_radiance));
}

}  // namespace pleinair
