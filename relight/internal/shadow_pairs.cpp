#include "relight/internal/shadow_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

// Clear of modelled edges, as far as a footprint of a pixel reaches.
constexpr float kClearOfEdgesPx = 1.5f;
// Below it a degree of error of the sun or the surface changes the light by a sixth.
constexpr float kLeastSunCosine = 0.1f;
// Pixels in one such cell of the map share their stains.
constexpr int kCellsAround = 128;
constexpr std::size_t kFewestCells = 4;
// Evenly taken out of larger sets: their medians are then off by less than 1 % of the scatter.
constexpr std::size_t kMostPoints = 8192;
// Of what a comparison's surfaces share, relative: as LightingFitOptions::shared_error; surfaces
// that face different ways see different parts of what the mesh lacks.
constexpr double kSameFacingError = 0.05;
constexpr double kOtherFacingError = 0.10;
constexpr double kHuber = 1.5;

struct Point {
  std::size_t pixel = 0;
  double weight = 0.0;  // Solid angle.
  int cell = 0;
};
using Points = std::vector<Point>;

struct Comparison {
  const Points* lit = nullptr;
  const Points* shaded = nullptr;
  double shared_error = 0.0;
};

// An estimate and its variance.
struct Estimate {
  double value = 0.0;
  double variance = 0.0;
};

// The nearest of the six axes.
int Facing(const glm::vec3& normal) {
  int axis = 0;
  for (int other = 1; other < 3; ++other) {
    if (std::abs(normal[other]) > std::abs(normal[axis])) axis = other;
  }
  return 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
}

struct Weighted {
  double value = 0.0;
  double weight = 0.0;
};

double Median(std::vector<Weighted>& values) {
  std::sort(values.begin(), values.end(), [](const Weighted& a, const Weighted& b) {
    return std::tie(a.value, a.weight) < std::tie(b.value, b.weight);
  });
  double whole = 0.0;
  for (const Weighted& value : values) whole += value.weight;
  double below = 0.0;
  for (const Weighted& value : values) {
    below += value.weight;
    if (below >= 0.5 * whole) return value.value;
  }
  return values.back().value;
}

class SunSearch {
 public:
  explicit SunSearch(const ShadowPairsInput& input) : input_(input), view_(input.view) { Sort(); }

  const std::vector<Comparison>& Comparisons() const { return comparisons_; }

  // Of one channel of a comparison; none where no sun explains it.
  std::optional<Estimate> SunOf(const Comparison& comparison, int channel) const {
    const double sky = input_.sky_irradiance_rgb[channel];
    // The lit ones' albedo falls with the sun and the shaded ones' hardly does: one crossing.
    const auto brighter_lit = [&](double sun) {
      return LogAlbedo(*comparison.lit, sun, channel) - LogAlbedo(*comparison.shaded, sun, channel);
    };
    double low = 0.0;
    double high = sky;
    // No clear sky's beam is more than some twenty times its diffuse light.
    constexpr double kMostOverSky = 100.0;
    while (brighter_lit(high) > 0.0) {
      low = high;
      high *= 2.0;
      if (high > kMostOverSky * sky) return std::nullopt;
    }
    constexpr double kPrecision = 1e-4;
    while (high - low > kPrecision * (sky + high)) {
      const double middle = 0.5 * (low + high);
      (brighter_lit(middle) > 0.0 ? low : high) = middle;
    }
    const double sun = 0.5 * (low + high);
    // How far the sun moves for a relative error of the albedos' ratio.
    const double step = 0.1 * (sun + sky);
    const double slope = (brighter_lit(sun) - brighter_lit(sun + step)) / step;
    if (!(slope > 0.0)) return std::nullopt;
    const double variance = comparison.shared_error * comparison.shared_error +
                            MedianVariance(*comparison.lit, sun, channel) +
                            MedianVariance(*comparison.shaded, sun, channel);
    return Estimate{sun, variance / (slope * slope)};
  }

 private:
  const ShadowPairsInput& input_;
  const SurfaceView& view_;
  // By material: all lit pixels; by material and facing: lit, in a cast shadow, turned away.
  std::map<std::uint32_t, Points> lit_;
  std::map<std::pair<std::uint32_t, int>, Points> lit_facing_;
  std::map<std::pair<std::uint32_t, int>, Points> cast_;
  std::map<std::pair<std::uint32_t, int>, Points> turned_;
  std::vector<Comparison> comparisons_;
  mutable std::vector<Weighted> scratch_;

  bool IsUsable(std::size_t i) const {
    if (input_.face.pixels[i] == PatchScene::kSky) return false;
    const auto patch = static_cast<std::size_t>(input_.face.pixels[i]) / 2;
    if (input_.patch_is_diffuse[patch] == 0 ||
        input_.scene.source_triangle[patch] == PatchScene::kExtension) {
      return false;
    }
    if (input_.mask != nullptr && input_.mask->pixels[i] != 255) return false;
    const glm::vec3& radiance = input_.radiance.pixels[i];
    return std::min({radiance.x, radiance.y, radiance.z}) > 0.0f &&
           view_.edge_distance_px.pixels[i] >= kClearOfEdgesPx;
  }

  void Sort() {
    const LatLongSize size{view_.Width(), view_.Height()};
    const int cell_px = std::max(1, size.width / kCellsAround);
    const glm::vec3 towards_sun(view_.sun_direction_enu);
    for (int y = 0; y < size.height; ++y) {
      const double weight = LatLongPixelSolidAngleSr(y, size);
      for (int x = 0; x < size.width; ++x) {
        const std::size_t i = view_.region.Index(x, y);
        if (!IsUsable(i)) continue;
        const glm::vec3& normal = view_.normal_world.pixels[i];
        const float cosine = glm::dot(normal, towards_sun);
        if (std::abs(cosine) < kLeastSunCosine) continue;
        const std::uint32_t material =
            input_.scene.mesh
                .triangle_material[static_cast<std::size_t>(input_.face.pixels[i]) / 2];
        const Point point{i, weight, y / cell_px * (kCellsAround + 1) + x / cell_px};
        const std::pair key{material, Facing(normal)};
        const float seen = view_.sun_visibility.pixels[i];
        if (cosine < 0.0f) {
          turned_[key].push_back(point);
        } else if (seen >= 1.0f) {
          lit_[material].push_back(point);
          lit_facing_[key].push_back(point);
        } else if (seen <= 0.0f) {
          cast_[key].push_back(point);
        }
      }
    }
    for (auto* sets : {&lit_facing_, &cast_, &turned_}) {
      for (auto& [key, points] : *sets) Thin(points);
    }
    for (auto& [key, points] : lit_) Thin(points);
    for (const auto& [key, shaded] : cast_) {
      const auto lit = lit_facing_.find(key);
      if (lit != lit_facing_.end()) Compare(lit->second, shaded, kSameFacingError);
    }
    for (const auto& [key, shaded] : turned_) {
      const auto lit = lit_.find(key.first);
      if (lit != lit_.end()) Compare(lit->second, shaded, kOtherFacingError);
    }
  }

  static void Thin(Points& points) {
    if (points.size() <= kMostPoints) return;
    for (std::size_t i = 0; i < kMostPoints; ++i)
      points[i] = points[i * points.size() / kMostPoints];
    points.resize(kMostPoints);
  }

  static std::size_t CellsOf(const Points& points) {
    std::vector<int> cells;
    for (const Point& point : points) cells.push_back(point.cell);
    std::sort(cells.begin(), cells.end());
    return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
  }

  void Compare(const Points& lit, const Points& shaded, double shared_error) {
    if (CellsOf(lit) < kFewestCells || CellsOf(shaded) < kFewestCells) return;
    comparisons_.push_back({&lit, &shaded, shared_error});
  }

  double LogAlbedoAt(std::size_t pixel, double sun, int channel) const {
    const double response = SunResponse(view_, pixel, view_.sun_direction_enu)[channel];
    const double irradiance =
        input_.sky_irradiance_rgb[channel] * view_.sky_response[0].pixels[pixel][channel] +
        sun * response;
    // What sees no light says nothing: it comes out as white, at one end of the medians.
    return irradiance > 0.0 ? std::log(input_.radiance.pixels[pixel][channel] / irradiance) : 0.0;
  }

  double LogAlbedo(const Points& points, double sun, int channel) const {
    scratch_.clear();
    for (const Point& point : points) {
      scratch_.push_back({LogAlbedoAt(point.pixel, sun, channel), point.weight});
    }
    return Median(scratch_);
  }

  // Of the median, from the scatter of the cells' own: a normal distribution's, each cell counting
  // by its weight.
  double MedianVariance(const Points& points, double sun, int channel) const {
    std::map<int, std::vector<Weighted>> cells;
    for (const Point& point : points) {
      cells[point.cell].push_back({LogAlbedoAt(point.pixel, sun, channel), point.weight});
    }
    std::vector<Weighted> medians;
    double whole = 0.0;
    double squares = 0.0;
    for (auto& [cell, values] : cells) {
      double weight = 0.0;
      for (const Weighted& value : values) weight += value.weight;
      medians.push_back({Median(values), weight});
      whole += weight;
      squares += weight * weight;
    }
    const double middle = Median(medians);
    for (Weighted& median : medians) median.value = std::abs(median.value - middle);
    const double scatter = 1.4826 * Median(medians);
    return 0.5 * std::numbers::pi * scatter * scatter * squares / (whole * whole);
  }
};

// Huber's mean, started at the weighted median.
Estimate RobustMean(const std::vector<Estimate>& estimates) {
  std::vector<Weighted> values;
  values.reserve(estimates.size());
  for (const Estimate& estimate : estimates) {
    values.push_back({estimate.value, 1.0 / estimate.variance});
  }
  Estimate mean{Median(values), 0.0};
  constexpr int kPasses = 20;
  double squares = 0.0;
  for (int pass = 0; pass < kPasses; ++pass) {
    double sum = 0.0;
    double weights = 0.0;
    squares = 0.0;
    for (const Estimate& estimate : estimates) {
      const double deviation = std::abs(estimate.value - mean.value) / std::sqrt(estimate.variance);
      const double weight = std::min(1.0, kHuber / std::max(deviation, kHuber)) / estimate.variance;
      sum += weight * estimate.value;
      weights += weight;
      squares += weight * estimate.variance * deviation * deviation;
    }
    mean = {sum / weights, 1.0 / weights};
  }
  // Comparisons that scatter more than they should say so.
  if (estimates.size() > 1) {
    mean.variance *= std::max(1.0, squares / static_cast<double>(estimates.size() - 1));
  }
  return mean;
}

}  // namespace

std::optional<SunFromShadows> MeasureSunFromShadows(const ShadowPairsInput& input) {
  const glm::dvec3& sky = input.sky_irradiance_rgb;
  if (!(std::min({sky.x, sky.y, sky.z}) > 0.0)) return std::nullopt;
  const SunSearch search(input);
  SunFromShadows sun;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<Estimate> estimates;
    sun.shaded_pixels = 0;
    for (const Comparison& comparison : search.Comparisons()) {
      const std::optional<Estimate> estimate = search.SunOf(comparison, channel);
      if (!estimate) continue;
      estimates.push_back(*estimate);
      sun.shaded_pixels += static_cast<int>(comparison.shaded->size());
    }
    if (estimates.empty()) return std::nullopt;
    sun.comparisons = static_cast<int>(estimates.size());
    const Estimate mean = RobustMean(estimates);
    sun.irradiance_rgb[channel] = mean.value;
    sun.stddev_rgb[channel] = std::sqrt(mean.variance);
  }
  return sun;
}

}  // namespace pleinair
