#include "pipeline/shadow_direction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// The picture is cut into this many blocks for the uncertainty.
constexpr int kBlocksX = 4;
constexpr int kBlocksY = 4;
constexpr std::size_t kBlocks = kBlocksX * kBlocksY;
// A pixel counts by its distance from its plane's level in log brightness, up to this: a lit and a
// shaded level are about 1.2 apart (3.5 : 1), what is farther off than half of that is another
// thing.
constexpr double kLargestCost = 0.6;
// A plane speaks when each of its two states has this many pixels.
constexpr std::size_t kLeastPixels = 30;

struct ShadowPixel {
  glm::vec3 start_m{0.0f};  // Of the shadow ray.
  glm::vec3 normal{0.0f};
  double log_brightness = 0.0;
  std::size_t block = 0;
};

// Pixels of one plane: same region, same facing.
using Planes = std::vector<std::vector<ShadowPixel>>;

double Luminance(const glm::vec3& rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

Planes CollectPlanes(const Frame& frame, const SurfaceView& view, int most_pixels) {
  std::map<std::array<int, 4>, std::vector<ShadowPixel>> planes;
  const double stride_exact = std::sqrt(double(view.region.pixels.size()) / most_pixels);
  const int stride = std::max(1, static_cast<int>(std::ceil(stride_exact)));
  for (int y = 0; y < view.Height(); y += stride) {
    for (int x = 0; x < view.Width(); x += stride) {
      const std::size_t i = view.region.Index(x, y);
      if (view.region.pixels[i] == SurfaceView::kNoRegion || frame.unusable.pixels[i] != 0)
        continue;
      const double brightness =
          Luminance(frame.radiance.pixels[i]) / Luminance(view.albedo_rgb.pixels[i]);
      if (!(brightness > 0.0) || !std::isfinite(brightness)) continue;
      const glm::vec3 normal = view.normal_world.pixels[i];
      ShadowPixel pixel;
      pixel.start_m = OffsetFromSurface(view.position_world_m.pixels[i], normal);
      pixel.normal = normal;
      pixel.log_brightness = std::log(brightness);
      pixel.block = static_cast<std::size_t>(kBlocksX * (kBlocksY * y / view.Height()) +
                                             kBlocksX * x / view.Width());
      planes[{view.region.pixels[i],
              static_cast<int>(std::lround(10.0f * normal.x)),
              static_cast<int>(std::lround(10.0f * normal.y)),
              static_cast<int>(std::lround(10.0f * normal.z))}]
          .push_back(pixel);
    }
  }
  Planes result;
  for (auto& [key, pixels] : planes) result.push_back(std::move(pixels));
  return result;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct PlaneCost {
  std::array<double, kBlocks> by_block{};
  bool both_states = false;
};

PlaneCost CostOf(const std::vector<ShadowPixel>& plane,
                 const RayCaster& caster,
                 const glm::vec3& sun_direction) {
  std::vector<bool> lit(plane.size());
  std::vector<double> lit_values;
  std::vector<double> shaded_values;
  std::vector<double> all_values;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    lit[i] = glm::dot(plane[i].normal, sun_direction) > 0.0f &&
             !caster.Occluded(plane[i].start_m, sun_direction);
    (lit[i] ? lit_values : shaded_values).push_back(plane[i].log_brightness);
    all_values.push_back(plane[i].log_brightness);
  }
  PlaneCost cost;
  cost.both_states = lit_values.size() >= kLeastPixels && shaded_values.size() >= kLeastPixels;
  double lit_level = MedianOf(all_values);
  double shaded_level = lit_level;
  if (!lit_values.empty() && !shaded_values.empty()) {
    const double lit_median = MedianOf(lit_values);
    const double shaded_median = MedianOf(shaded_values);
    // Shade that is brighter than sun explains nothing: one level serves both.
    if (lit_median > shaded_median) {
      lit_level = lit_median;
      shaded_level = shaded_median;
    }
  }
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const double distance = std::abs(plane[i].log_brightness - (lit[i] ? lit_level : shaded_level));
    cost.by_block[plane[i].block] += std::min(distance, kLargestCost);
  }
  return cost;
}

glm::vec3 TurnedClockwise(const glm::dvec3& direction_enu, double azimuth_rad) {
  const double c = std::cos(azimuth_rad);
  const double s = std::sin(azimuth_rad);
  return glm::vec3(c * direction_enu.x + s * direction_enu.y,
                   -s * direction_enu.x + c * direction_enu.y,
                   direction_enu.z);
}

// Position of the lowest cost between the candidates, by a parabola; none at an end.
std::optional<double> Minimum(const std::vector<double>& costs) {
  const auto lowest = std::min_element(costs.begin(), costs.end());
  if (lowest == costs.begin() || lowest + 1 == costs.end()) return std::nullopt;
  const double curvature = lowest[-1] - 2.0 * lowest[0] + lowest[1];
  const double shift = curvature > 0.0 ? 0.5 * (lowest[-1] - lowest[1]) / curvature : 0.0;
  return double(lowest - costs.begin()) + shift;
}

}  // namespace

std::optional<ShadowDirection> MeasureShadowDirection(const Frame& frame,
                                                      const SurfaceView& view,
                                                      const RayCaster& caster,
                                                      const glm::dvec3& sun_direction_enu,
                                                      const ShadowDirectionOptions& options) {
  const Planes planes = CollectPlanes(frame, view, options.pixels);
  const int half = static_cast<int>(std::floor(options.largest_offset_rad / options.step_rad));
  std::vector<std::array<double, kBlocks>> costs(static_cast<std::size_t>(2 * half + 1));
  bool both_states = false;
  for (int k = -half; k <= half; ++k) {
    const glm::vec3 sun = TurnedClockwise(sun_direction_enu, k * options.step_rad);
    std::array<double, kBlocks>& cost = costs[static_cast<std::size_t>(k + half)];
    for (const std::vector<ShadowPixel>& plane : planes) {
      const PlaneCost plane_cost = CostOf(plane, caster, sun);
      both_states |= plane_cost.both_states;
      for (std::size_t block = 0; block < kBlocks; ++block) {
        cost[block] += plane_cost.by_block[block];
      }
    }
  }
  if (!both_states) return std::nullopt;

  const auto minimum_without = [&](std::size_t left_out) {
    std::vector<double> sums;
    for (const std::array<double, kBlocks>& cost : costs) {
      double sum = 0.0;
      for (std::size_t block = 0; block < kBlocks; ++block) {
        if (block != left_out) sum += cost[block];
      }
      sums.push_back(sum);
    }
    return Minimum(sums);
  };
  const std::optional<double> all = minimum_without(kBlocks);
  if (!all) return std::nullopt;
  // Jackknife: variance = (n - 1) / n * sum of squared deviations of the leave-one-out estimates.
  double squares = 0.0;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    const std::optional<double> without = minimum_without(block);
    const double deviation = without ? *without - *all : double(half);
    squares += deviation * deviation;
  }
  const double steps = std::sqrt(squares * double(kBlocks - 1) / double(kBlocks));
  return ShadowDirection{(*all - half) * options.step_rad, steps * options.step_rad};
}

}  // namespace pleinair
