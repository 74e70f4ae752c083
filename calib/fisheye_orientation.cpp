#include "calib/fisheye_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/residual_text.h"
#include "scene/angle_between.h"
#include "sunmodel/angles.h"
#include "sunmodel/refraction.h"
#include "sunmodel/sun_position.h"

namespace pleinair {
namespace {

glm::dvec3 Unit(const glm::dvec3& direction, const char* what, std::size_t index) {
  const double length = glm::length(direction);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument(std::string("mark ") + std::to_string(index + 1) + ": " + what +
                                ": expected a direction");
  }
  return direction / length;
}

// Angle between the lines: 0 for opposite directions too.
double SpreadBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b)));
}

// argmin over (mirrored) rotations R of sum |world - R camera|^2.
glm::dmat3 LeastSquares(std::span<const DirectionPair> units,
                        const std::vector<bool>& counts,
                        Handedness handedness) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (!counts[i]) continue;
    const glm::dvec3& camera = units[i].direction_camera;
    const glm::dvec3& world = units[i].direction_world;
    sum += Eigen::Vector3d(world.x, world.y, world.z) *
           Eigen::Vector3d(camera.x, camera.y, camera.z).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double wanted = handedness == Handedness::kMirrored ? -1.0 : 1.0;
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() * wanted < 0.0) signs[2] = -1.0;
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  glm::dmat3 result;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) result[column][row] = rotation(row, column);
  }
  return result;
}

// Columns: a, then perpendicular to it towards b, then their cross product.
glm::dmat3 Triad(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 side = glm::normalize(b - glm::dot(a, b) * a);
  return {a, side, glm::cross(a, side)};
}

glm::dmat3 FromTwo(const DirectionPair& first, const DirectionPair& second, Handedness handedness) {
  const glm::dmat3 world = Triad(first.direction_world, second.direction_world);
  glm::dmat3 camera = Triad(first.direction_camera, second.direction_camera);
  if (handedness == Handedness::kMirrored) camera[2] = -camera[2];
  return world * glm::transpose(camera);
}

std::vector<double> Residuals(std::span<const DirectionPair> units, const glm::dmat3& rotation) {
  std::vector<double> residuals;
  for (const DirectionPair& pair : units) {
    residuals.push_back(AngleBetweenRad(rotation * pair.direction_camera, pair.direction_world));
  }
  return residuals;
}

struct Agreement {
  std::vector<bool> counts;
  int count = 0;
  double squared_sum = 0.0;

  bool BetterThan(const Agreement& other) const {
    return count > other.count || (count == other.count && squared_sum < other.squared_sum);
  }
};

Agreement AgreeingWith(std::span<const DirectionPair> units,
                       const glm::dmat3& rotation,
                       double outlier_rad) {
  Agreement agreement;
  for (const double residual : Residuals(units, rotation)) {
    const bool counts = residual <= outlier_rad;
    agreement.counts.push_back(counts);
    if (!counts) continue;
    ++agreement.count;
    agreement.squared_sum += residual * residual;
  }
  return agreement;
}

// Connected pixels of kBlobShare of the brightest one's light or more.
constexpr float kBlobShare = 0.5f;
// Values above this share are equal but for rounding by the file's format and merging.
constexpr float kFlatShare = 0.995f;

struct Blob {
  glm::dvec3 flux_direction{0.0};  // Sum of light times solid angle times direction.
  double flux = 0.0;
  double solid_angle_sr = 0.0;
  int flat_count = 0;  // Pixels as bright as the brightest.
};

Blob TakeBlob(const Image<float>& light,
              const FisheyeLens& lens,
              float brightest,
              const glm::ivec2& start,
              Gray8Image& taken) {
  Blob blob;
  std::vector<glm::ivec2> open{start};
  taken.At(start.x, start.y) = 1;
  while (!open.empty()) {
    const glm::ivec2 at = open.back();
    open.pop_back();
    const double solid_angle_sr = lens.PixelSolidAngleSr(at);
    const double flux = solid_angle_sr * light.At(at.x, at.y);
    blob.flux_direction += flux * *lens.DirectionFromPixel(at);
    blob.flux += flux;
    blob.solid_angle_sr += solid_angle_sr;
    blob.flat_count += light.At(at.x, at.y) >= kFlatShare * brightest ? 1 : 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const glm::ivec2 next = at + glm::ivec2(dx, dy);
        if (!taken.Contains(next.x, next.y) || taken.At(next.x, next.y) != 0) continue;
        taken.At(next.x, next.y) = 1;
        if (light.At(next.x, next.y) >= kBlobShare * brightest) {
          open.push_back(next);
        } else if (light.At(next.x, next.y) > 0.0f) {
          // A small disc covers the pixels at its limb in part: they too determine its centre.
          blob.flux_direction += lens.PixelSolidAngleSr(next) *
                                 static_cast<double>(light.At(next.x, next.y)) *
                                 *lens.DirectionFromPixel(next);
        }
      }
    }
  }
  return blob;
}

}  // namespace

OrientationFit FitOrientation(std::span<const DirectionPair> pairs,
                              const OrientationOptions& options) {
  if (pairs.size() < 2) {
    throw std::invalid_argument("marks: expected two or more, found " +
                                std::to_string(pairs.size()));
  }
  std::vector<DirectionPair> units;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    units.push_back({Unit(pairs[i].direction_camera, "direction in the camera", i),
                     Unit(pairs[i].direction_world, "direction in the world", i)});
  }

  Agreement best;
  bool spread_enough = false;
  for (std::size_t i = 0; i < units.size(); ++i) {
    for (std::size_t j = i + 1; j < units.size(); ++j) {
      const double spread =
          std::min(SpreadBetween(units[i].direction_camera, units[j].direction_camera),
                   SpreadBetween(units[i].direction_world, units[j].direction_world));
      if (!(spread >= kLeastSpreadRad)) continue;
      spread_enough = true;
      const Agreement agreement =
          AgreeingWith(units, FromTwo(units[i], units[j], options.handedness), options.outlier_rad);
      // Two pairs always determine a rotation; they agree on it only where both fit.
      if (agreement.count >= 2 && agreement.BetterThan(best)) best = agreement;
    }
  }
  if (!spread_enough) {
    throw std::runtime_error(
        "orientation: cannot be determined: expected marks in two directions, 3 degrees or more "
        "from "
        "one line");
  }
  if (best.count < 2) {
    throw std::runtime_error(
        "orientation: cannot be determined: expected two marks or more that agree on one");
  }
  OrientationFit fit;
  fit.counts = best.counts;
  fit.world_from_camera = LeastSquares(units, fit.counts, options.handedness);
  fit.residual_rad = Residuals(units, fit.world_from_camera);
  double sum = 0.0;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (fit.counts[i]) sum += fit.residual_rad[i] * fit.residual_rad[i];
  }
  fit.rms_rad = std::sqrt(sum / best.count);
  return fit;
}

OrientationFit OrientationFromUp(const glm::dvec3& up_camera,
                                 const DirectionPair& mark,
                                 Handedness handedness) {
  const DirectionPair up{Unit(up_camera, "up", 0), {0.0, 0.0, 1.0}};
  const DirectionPair unit{Unit(mark.direction_camera, "direction in the camera", 0),
                           Unit(mark.direction_world, "direction in the world", 0)};
  if (!(SpreadBetween(up.direction_camera, unit.direction_camera) >= kLeastSpreadRad) ||
      !(SpreadBetween(up.direction_world, unit.direction_world) >= kLeastSpreadRad)) {
    throw std::runtime_error(
        "orientation: cannot be determined: expected a sun or mark 3 degrees or more from the "
        "zenith");
  }
  OrientationFit fit;
  fit.world_from_camera = FromTwo(up, unit, handedness);
  const std::array<DirectionPair, 1> marks{unit};
  fit.residual_rad = Residuals(marks, fit.world_from_camera);
  fit.counts = {true};
  fit.rms_rad = fit.residual_rad[0];
  return fit;
}

double AxisFromZenithRad(const OrientationFit& fit) {
  return AngleBetweenRad(fit.world_from_camera[2], {0.0, 0.0, 1.0});
}

std::string DoubtAbout(const OrientationFit& fit) {
  if (!(fit.rms_rad <= kLargestCredibleOffRad)) {
    return NumberText("the sun or mark is off by %.1f deg", DegFromRad(fit.rms_rad)) +
           NumberText(": expected at most %.0f deg", DegFromRad(kLargestCredibleOffRad));
  }
  const auto agreeing = std::count(fit.counts.begin(), fit.counts.end(), true);
  if (agreeing == 2 && fit.counts.size() > 2) {
    return "2 of " + std::to_string(fit.counts.size()) +
           " suns or marks agree: expected three or more";
  }
  const double axis_rad = AxisFromZenithRad(fit);
  if (axis_rad <= kLowestCredibleAxisRad) return {};
  return NumberText("the axis would be %.1f deg from the zenith: expected a sky camera's",
                    DegFromRad(axis_rad));
}

glm::dvec3 ApparentSunDirectionEnu(const Site& site, UtcTime time) {
  return ApparentDirection(ComputeSunPosition(site, time).direction_enu,
                           StandardAtmosphere(site.height_m));
}

std::optional<SunImage> FindSunImage(const RgbImage& radiance, const FisheyeLens& lens) {
  const int width = radiance.width;
  const int height = radiance.height;
  // The channels' sum: no channel alone decides, and none may be missing. What the lens does not
  // see, and what is no number, is dark.
  Image<float> light(width, height, 0.0f);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3& pixel = radiance.At(x, y);
      const float sum = pixel.x + pixel.y + pixel.z;
      if (sum > 0.0f && std::isfinite(sum) && lens.DirectionFromPixel({x, y})) {
        light.At(x, y) = sum;
      }
    }
  }
  const auto brightest = std::max_element(light.pixels.begin(), light.pixels.end());
  if (brightest == light.pixels.end() || !(*brightest > 0.0f)) return std::nullopt;

  Gray8Image taken(width, height);
  Blob largest;
  double all_flux = 0.0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (taken.At(x, y) != 0 || light.At(x, y) < kBlobShare * *brightest) continue;
      const Blob blob = TakeBlob(light, lens, *brightest, {x, y}, taken);
      all_flux += blob.flux;
      if (blob.flux > largest.flux) largest = blob;
    }
  }
  // As bright elsewhere: clouds or lamps; which one is the sun is unknown. A flare or two
  // are well below this.
  constexpr double kLeastShare = 0.75;
  if (!(largest.flux >= kLeastShare * all_flux)) return std::nullopt;
  SunImage sun;
  // Solid angle of a cap, 2 pi (1 - cos r) = 4 pi sin^2(r / 2).
  sun.angular_radius_rad =
      2.0 * std::asin(std::min(std::sqrt(largest.solid_angle_sr / (4.0 * std::numbers::pi)), 1.0));
  if (!(sun.angular_radius_rad <= kLargestSunRad)) return std::nullopt;
  sun.direction_camera = glm::normalize(largest.flux_direction);
  // A disc that is not clipped has a limb and a few pixels of aliasing: not four equal pixels.
  sun.clipped = largest.flat_count >= 4;
  return sun;
}

}  // namespace pleinair
