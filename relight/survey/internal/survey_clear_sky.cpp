#include "relight/survey/internal/survey_clear_sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/angle_between.h"
#include "scene/lat_long.h"
#include "scene/upper_median.h"
#include "sunmodel/angles.h"
#include "sunmodel/sky_luminance.h"

namespace pleinair {
namespace {

// From air alone to dust; the standard depth is among them.
constexpr std::array<double, 12> kDepths{
    0.0, 0.01, 0.02, 0.03, 0.05, kStandardAerosolDepth500nm, 0.12, 0.18, 0.27, 0.4, 0.6, 1.0};
// Clouds are large: a sky is not more than some dozens of independent readings.
constexpr double kIndependentReadings = 50.0;
// Before the sky is looked at, the depth is the standard one within a factor e; the offset
// leaves air without haze within reach.
constexpr double kDepthOffset = 0.01;
// The sun's disc, and what a lens spreads of it.
const double kAroundTheSunRad = RadFromDeg(2.0);
// Below, far buildings and hills that the mesh lacks.
const double kLeastElevationRad = RadFromDeg(3.0);
constexpr int kEdgePx = 3;  // A mesh's outline may be as much off.
constexpr double kRowsWanted = 90.0;
constexpr std::size_t kLeastReadings = 300;
// Values below this share of the median count as uncertain as it.
constexpr double kNoiseFloor = 0.2;
constexpr double kTukeyWidth = 4.0;
constexpr int kPasses = 15;
// A synthetic sky may fit exactly; a camera's is not measured better.
constexpr double kLeastSpread = 2e-3;
// Real skies, clear to partly cloudy, differ from the best mix by 10 to 24 %. Made-up clouds all
// over, and buildings that the mesh lacks, differ by 45 % and more.
constexpr double kMostSpread = 0.3;

struct Reading {
  glm::dvec3 direction_enu;
  glm::dvec3 radiance;
};

bool ShowsSkyAround(const Gray8Image& shows_sky, int x, int y) {
  for (const auto& [dx, dy] :
       {std::pair{0, 0}, {kEdgePx, 0}, {-kEdgePx, 0}, {0, kEdgePx}, {0, -kEdgePx}}) {
    const int column = (x + dx + shows_sky.width) % shows_sky.width;
    const int row = std::clamp(y + dy, 0, shows_sky.height - 1);
    if (shows_sky.At(column, row) == 0) return false;
  }
  return true;
}

// Equally dense over the sphere.
std::vector<Reading> ReadSky(const RgbImage& radiance,
                             const Gray8Image& shows_sky,
                             const glm::dvec3& sun_direction_enu) {
  std::vector<Reading> readings;
  const LatLongSize size{radiance.width, radiance.height};
  const int upper_rows = radiance.height / 2;
  const int step = std::max(1, static_cast<int>(upper_rows / kRowsWanted));
  const int columns_in_all = radiance.width / step;
  for (int y = step / 2; y < upper_rows; y += step) {
    const double circle = DirectionFromLatLong({0.5, y + 0.5}, size).z;
    const double around = std::sqrt(std::max(0.0, 1.0 - circle * circle));
    const int columns = std::max(1, static_cast<int>(columns_in_all * around));
    for (int k = 0; k < columns; ++k) {
      const int x = static_cast<int>((k + 0.5) * radiance.width / columns);
      if (!ShowsSkyAround(shows_sky, x, y)) continue;
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, size);
      const double from_sun = AngleBetweenRad(direction, sun_direction_enu);
      if (direction.z < std::sin(kLeastElevationRad) || from_sun < kAroundTheSunRad) continue;
      readings.push_back({direction, glm::dvec3(radiance.At(x, y))});
    }
  }
  return readings;
}

// argmin over x >= 0 of x' normal x - 2 x' target, among all choices of what is above 0.
glm::dvec3 NonNegativeMinimum(const glm::dmat3& normal, const glm::dvec3& target) {
  glm::dvec3 best(0.0);
  double least = 0.0;
  for (int chosen = 1; chosen < 8; ++chosen) {
    glm::dmat3 part(1.0);
    glm::dvec3 part_target(0.0);
    for (int i = 0; i < 3; ++i) {
      if ((chosen >> i & 1) == 0) continue;
      part_target[i] = target[i];
      for (int j = 0; j < 3; ++j) {
        if ((chosen >> j & 1) != 0) part[j][i] = normal[j][i];
      }
    }
    const double determinant = glm::determinant(part);
    if (!(std::abs(determinant) > 1e-12 * part[0][0] * part[1][1] * part[2][2])) continue;
    const glm::dvec3 x = glm::inverse(part) * part_target;
    if (!(std::min({x.x, x.y, x.z}) >= 0.0)) continue;
    const double value = glm::dot(x, normal * x) - 2.0 * glm::dot(x, target);
    if (value < least) {
      least = value;
      best = x;
    }
  }
  return best;
}

// A uniform, an overcast and a cloudless sky's shares, and the robust standard deviation of the
// relative difference to them.
struct Mix {
  glm::dvec3 shares{0.0};
  double spread = 0.0;
};

Mix FitMix(std::span<const glm::dvec3> shapes, std::span<const double> radiance) {
  const double floor = kNoiseFloor * UpperMedian({radiance.begin(), radiance.end()});
  std::vector<double> weight(radiance.size(), 1.0);
  std::vector<double> off(radiance.size());
  Mix mix;
  for (int pass = 0; pass < kPasses; ++pass) {
    glm::dmat3 normal(0.0);
    glm::dvec3 target(0.0);
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      const double noise = std::max(radiance[i], floor);
      const double w = weight[i] / (noise * noise);
      normal += glm::outerProduct(w * shapes[i], shapes[i]);
      target += w * radiance[i] * shapes[i];
    }
    mix.shares = NonNegativeMinimum(normal, target);
    std::vector<double> size(radiance.size());
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      off[i] = (glm::dot(mix.shares, shapes[i]) - radiance[i]) / std::max(radiance[i], floor);
      size[i] = std::abs(off[i]);
    }
    mix.spread = std::max(1.4826 * UpperMedian(std::move(size)), kLeastSpread);
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      const double t = off[i] / (kTukeyWidth * mix.spread);
      weight[i] = t * t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
    }
  }
  return mix;
}

// A cloudless sky relative to its zenith.
class RelativeClearSky {
 public:
  RelativeClearSky(const glm::dvec3& sun_direction_enu, double depth)
      : sky_(sun_direction_enu, depth), zenith_(sky_.Radiance({0.0, 0.0, 1.0})) {}

  // Uniform, overcast, cloudless, of one channel.
  glm::dvec3 Shapes(const glm::dvec3& direction, int channel) const {
    return {1.0, OvercastSkyLuminance(direction), Radiance(direction)[channel]};
  }
  glm::dvec3 Radiance(const glm::dvec3& direction) const {
    return sky_.Radiance(direction) / zenith_;
  }
  // On a horizontal plane.
  glm::dvec3 Irradiance() const {
    constexpr LatLongSize kSize{64, 32};
    glm::dvec3 sum(0.0);
    for (int y = 0; y < kSize.height / 2; ++y) {
      for (int x = 0; x < kSize.width; ++x) {
        const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, kSize);
        sum += LatLongPixelSolidAngleSr(y, kSize) * direction.z * Radiance(direction);
      }
    }
    return sum;
  }

 private:
  ClearSkyDistribution sky_;
  glm::dvec3 zenith_;
};

}  // namespace

std::optional<ClearSkyOfMap> MeasureClearSky(const RgbImage& radiance,
                                             const Gray8Image& shows_sky,
                                             const glm::dvec3& sun_direction_enu) {
  if (!(sun_direction_enu.z > 0.0)) return std::nullopt;
  const std::vector<Reading> readings = ReadSky(radiance, shows_sky, sun_direction_enu);
  if (readings.size() < kLeastReadings) return std::nullopt;

  std::array<std::vector<double>, 3> of_channel;
  for (int c = 0; c < 3; ++c) {
    std::vector<double>& values = of_channel[static_cast<std::size_t>(c)];
    for (const Reading& reading : readings) values.push_back(reading.radiance[c]);
    if (!(UpperMedian(values) > 0.0)) return std::nullopt;  // Night, or a dead channel.
  }
  std::optional<ClearSkyOfMap> best;
  double least_cost = std::numeric_limits<double>::infinity();
  std::vector<glm::dvec3> shapes(readings.size());
  for (const double depth : kDepths) {
    const RelativeClearSky clear(sun_direction_enu, depth);
    std::array<Mix, 3> mixes;
    double log_spread = 0.0;
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < readings.size(); ++i) {
        shapes[i] = clear.Shapes(readings[i].direction_enu, c);
      }
      Mix& mix = mixes[static_cast<std::size_t>(c)];
      mix = FitMix(shapes, of_channel[static_cast<std::size_t>(c)]);
      log_spread += std::log(mix.spread) / 3.0;
    }
    const double unlikely =
        std::log((depth + kDepthOffset) / (kStandardAerosolDepth500nm + kDepthOffset));
    const double cost = kIndependentReadings * log_spread + 0.5 * unlikely * unlikely;
    if (!(cost < least_cost)) continue;
    least_cost = cost;
    best = ClearSkyOfMap{depth, std::nullopt};
    if (!(log_spread < std::log(kMostSpread))) continue;
    const glm::dvec3 cloudless = clear.Irradiance();
    glm::dvec3& irradiance = best->irradiance_rgb.emplace();
    for (int c = 0; c < 3; ++c) {
      constexpr double kOvercastShare = 7.0 / 9.0;  // Of what a sky as its zenith would give.
      const glm::dvec3& shares = mixes[static_cast<std::size_t>(c)].shares;
      irradiance[c] =
          std::numbers::pi * (shares.x + kOvercastShare * shares.y) + shares.z * cloudless[c];
    }
  }
  return best;
}

}  // namespace pleinair
