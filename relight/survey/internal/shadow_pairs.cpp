#include "relight/survey/internal/shadow_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

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
// Larger sets are thinned evenly to this size: their medians are then off by less than 1 % of the
// scatter.
constexpr std::size_t kMostPoints = 8192;
// Relative error that a comparison's surfaces share: as LightingFitOptions::shared_error; surfaces
// that face different ways see different parts of what the mesh lacks.
constexpr double kSameFacingError = 0.05;
constexpr double kOtherFacingError = 0.10;
// Between the channels' errors: what the mesh lacks, and most stains, darken all of them.
constexpr double kChannelCorrelation = 0.8;
constexpr double kStudentDegrees = 4.0;
// A few cells scatter by chance less than surfaces do.
constexpr double kLeastCellScatter = 0.15;

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

  // Log ratio of the lit pixels' albedo to the shaded ones'. It falls with a stronger sun: the lit
  // ones' albedo falls, the shaded ones' hardly changes.
  double LitOverShaded(const Comparison& comparison, double sun, int channel) const {
    return LogAlbedo(*comparison.lit, sun, channel) - LogAlbedo(*comparison.shaded, sun, channel);
  }

  double VarianceOf(const Comparison& comparison, double sun, int channel) const {
    return comparison.shared_error * comparison.shared_error +
           MedianVariance(*comparison.lit, sun, channel) +
           MedianVariance(*comparison.shaded, sun, channel);
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

  // Beyond it a misplaced mesh shows the same surface.
  float ClearOfEdgesPx(std::size_t i) const {
    const double pixel_rad = std::numbers::pi / view_.Height();
    const double range_m = glm::distance(view_.position_world_m.pixels[i], input_.origin_m);
    const Misplacement& off = input_.misplacement;
    return kClearOfEdgesPx +
           static_cast<float>((off.turned_rad + off.moved_m / range_m) / pixel_rad);
  }

  bool IsUsable(std::size_t i) const {
    if (input_.face.pixels[i] == PatchScene::kSky) return false;
    const auto patch = static_cast<std::size_t>(input_.face.pixels[i]) / 2;
    if (input_.patch_is_diffuse[patch] == 0 || input_.scene.IsExtension(patch)) {
      return false;
    }
    if (input_.mask != nullptr && input_.mask->pixels[i] != 255) return false;
    const glm::vec3& radiance = input_.radiance.pixels[i];
    return std::min({radiance.x, radiance.y, radiance.z}) > 0.0f &&
           input_.mesh_edge_distance_px.pixels[i] >= ClearOfEdgesPx(i);
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
            input_.scene.MaterialOf(static_cast<std::size_t>(input_.face.pixels[i]) / 2);
        const Point point{i, weight, y / cell_px * (kCellsAround + 1) + x / cell_px};
        const std::pair key{material, Facing(normal)};
        if (input_.side.pixels[i] == ShadowSide::kLit) {
          lit_[material].push_back(point);
          lit_facing_[key].push_back(point);
        } else if (input_.side.pixels[i] == ShadowSide::kShaded) {
          (cosine < 0.0f ? turned_ : cast_)[key].push_back(point);
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
    // A pixel that sees no light carries no information: its albedo would be white, at one end of
    // the medians.
    return irradiance > 0.0 ? std::log(input_.radiance.pixels[pixel][channel] / irradiance) : 0.0;
  }

  double LogAlbedo(const Points& points, double sun, int channel) const {
    scratch_.clear();
    for (const Point& point : points) {
      scratch_.push_back({LogAlbedoAt(point.pixel, sun, channel), point.weight});
    }
    return Median(scratch_);
  }

  // Variance of the median, from the scatter of the cells' medians: that of a normal distribution,
  // each cell counting by its weight.
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
    const double scatter = std::max(1.4826 * Median(medians), kLeastCellScatter);
    return 0.5 * std::numbers::pi * scatter * scatter * squares / (whole * whole);
  }
};

// All channels' errors, of which `correlation` is between any two of them.
glm::dmat3 Covariance(const glm::dvec3& variance, double correlation) {
  const glm::dvec3 stddev = glm::sqrt(variance);
  glm::dmat3 covariance = correlation * glm::outerProduct(stddev, stddev);
  for (int c = 0; c < 3; ++c) covariance[c][c] = variance[c];
  return covariance;
}

glm::dmat3 Covariance(const SunPrior& prior) {
  const double shared = prior.shared_log_stddev * prior.shared_log_stddev;
  const double hue = prior.hue_log_stddev * prior.hue_log_stddev;
  return Covariance(glm::dvec3(shared + hue), shared / (shared + hue));
}

// A comparison's information on the sun or its logarithm, linearised at one value.
struct Linearised {
  glm::dvec3 difference{0.0};  // LitOverShaded.
  glm::dvec3 slope{0.0};
  glm::dmat3 information{0.0};  // Inverse of the difference's covariance.

  double Distance2() const { return glm::dot(difference, information * difference); }
  // Of Student's t distribution, as a factor of the information.
  double Weight() const { return (kStudentDegrees + 3.0) / (kStudentDegrees + Distance2()); }
  // Its logarithm, but for a constant.
  double LogDensity() const {
    return 0.5 * std::log(glm::determinant(information)) -
           0.5 * (kStudentDegrees + 3.0) * std::log1p(Distance2() / kStudentDegrees);
  }
};

Linearised LineariseAt(const SunSearch& search,
                       const Comparison& comparison,
                       const glm::dvec3& log_sun) {
  constexpr double kStep = 0.05;
  Linearised at;
  glm::dvec3 variance;
  for (int c = 0; c < 3; ++c) {
    at.difference[c] = search.LitOverShaded(comparison, std::exp(log_sun[c]), c);
    const double more = search.LitOverShaded(comparison, std::exp(log_sun[c] + kStep), c);
    const double less = search.LitOverShaded(comparison, std::exp(log_sun[c] - kStep), c);
    at.slope[c] = (more - less) / (2.0 * kStep);
    variance[c] = search.VarianceOf(comparison, std::exp(log_sun[c]), c);
  }
  at.information = glm::inverse(Covariance(variance, kChannelCorrelation));
  return at;
}

// At no sun at all; the slope is that over the sun itself, from there to a `step`.
Linearised LineariseAtNone(const SunSearch& search,
                           const Comparison& comparison,
                           const glm::dvec3& step) {
  Linearised at;
  glm::dvec3 variance;
  for (int c = 0; c < 3; ++c) {
    at.difference[c] = search.LitOverShaded(comparison, 0.0, c);
    at.slope[c] = (search.LitOverShaded(comparison, step[c], c) - at.difference[c]) / step[c];
    variance[c] = search.VarianceOf(comparison, 0.0, c);
  }
  at.information = glm::inverse(Covariance(variance, kChannelCorrelation));
  return at;
}

// An estimate, and the logarithm of its evidence: of the probability of all comparisons under it.
struct Explained {
  glm::dvec3 irradiance_rgb{0.0};
  glm::dvec3 stddev_rgb{0.0};
  double log_evidence = 0.0;
};

// Information that weighted comparisons add, and the pull of their differences.
void Add(const Linearised& at, glm::dmat3& information, glm::dvec3& pull) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double each = at.Weight() * at.information[column][row] * at.slope[row];
      information[column][row] += each * at.slope[column];
      pull[row] -= each * at.difference[column];
    }
  }
}

Explained ExplainBySun(const SunSearch& search, const SunPrior& prior) {
  const glm::dmat3 prior_information = glm::inverse(Covariance(prior));
  const glm::dvec3 prior_log = glm::log(prior.median_rgb);
  glm::dvec3 log_sun = prior_log;
  glm::dmat3 information(0.0);
  double log_density = 0.0;
  constexpr int kMostSteps = 20;
  constexpr double kLongestStep = 0.5;
  constexpr double kSettled = 1e-4;
  for (int step = 0; step < kMostSteps; ++step) {
    information = prior_information;
    const glm::dvec3 from_prior = prior_log - log_sun;
    glm::dvec3 pull = prior_information * from_prior;
    log_density = -0.5 * glm::dot(from_prior, pull);
    for (const Comparison& comparison : search.Comparisons()) {
      const Linearised at = LineariseAt(search, comparison, log_sun);
      log_density += at.LogDensity();
      Add(at, information, pull);
    }
    const glm::dvec3 move =
        glm::clamp(glm::inverse(information) * pull, -kLongestStep, kLongestStep);
    log_sun += move;
    if (glm::length(move) < kSettled) break;
  }
  const glm::dmat3 covariance = glm::inverse(information);
  Explained sun;
  for (int c = 0; c < 3; ++c) {
    sun.irradiance_rgb[c] = std::exp(log_sun[c]);
    sun.stddev_rgb[c] = sun.irradiance_rgb[c] * std::sqrt(covariance[c][c]);
  }
  sun.log_evidence = log_density + 0.5 * std::log(glm::determinant(prior_information) /
                                                  glm::determinant(information));
  return sun;
}

// A faint sun, as behind thin cloud, may be taken for none: the deviation reaches up to the one
// that the comparisons ask for.
Explained ExplainByNone(const SunSearch& search, const SunPrior& prior) {
  constexpr double kSmallPart = 0.02;
  Explained none;
  glm::dmat3 information(0.0);
  for (int c = 0; c < 3; ++c) {
    information[c][c] = 1.0 / (prior.median_rgb[c] * prior.median_rgb[c]);
  }
  glm::dvec3 pull(0.0);
  for (const Comparison& comparison : search.Comparisons()) {
    const Linearised at = LineariseAtNone(search, comparison, kSmallPart * prior.median_rgb);
    none.log_evidence += at.LogDensity();
    Add(at, information, pull);
  }
  const glm::dmat3 covariance = glm::inverse(information);
  const glm::dvec3 asked_for = glm::max(covariance * pull, glm::dvec3(0.0));
  for (int c = 0; c < 3; ++c) {
    none.stddev_rgb[c] = std::hypot(std::sqrt(covariance[c][c]), asked_for[c]);
  }
  return none;
}

}  // namespace

std::optional<SunFromShadows> MeasureSunFromShadows(const ShadowPairsInput& input) {
  const glm::dvec3& sky = input.sky_irradiance_rgb;
  const glm::dvec3& median = input.prior.median_rgb;
  if (!(std::min({sky.x, sky.y, sky.z, median.x, median.y, median.z}) > 0.0)) return std::nullopt;
  const SunSearch search(input);
  if (search.Comparisons().empty()) return std::nullopt;

  Explained best = ExplainBySun(search, input.prior);
  const double chance_of_none = input.prior.chance_of_none;
  if (chance_of_none > 0.0) {
    const Explained none = ExplainByNone(search, input.prior);
    const double log_odds = std::log(chance_of_none / (1.0 - chance_of_none));
    if (none.log_evidence + log_odds > best.log_evidence) best = none;
  }
  SunFromShadows sun{best.irradiance_rgb, best.stddev_rgb};
  sun.comparisons = static_cast<int>(search.Comparisons().size());
  for (const Comparison& comparison : search.Comparisons()) {
    sun.shaded_pixels += static_cast<int>(comparison.shaded->size());
  }
  return sun;
}

}  // namespace pleinair
