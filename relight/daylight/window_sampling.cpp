#include "relight/daylight/window_sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "relight/daylight/internal/wall_openings.h"
#include "relight/transport/convex_hull.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// No point of a cell is farther from its centre: at the horizon, where cells are stretched most, it
// is half of 2 by 1 times their side on the disc.
constexpr double kCellRadiusRad = 2.236068 / SkyTable::kSide;

double Brightness(const glm::vec3& rgb) {
  return static_cast<double>(rgb.x) + static_cast<double>(rgb.y) + static_cast<double>(rgb.z);
}

// Cell number `step` of the Hilbert curve over the table.
std::uint32_t HilbertCell(std::uint32_t step) {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  for (std::uint32_t side = 1; side < SkyTable::kSide; side *= 2) {
    const std::uint32_t right = 1u & (step / 2);
    const std::uint32_t up = 1u & (step ^ right);
    if (up == 0) {
      if (right == 1) {
        x = side - 1 - x;
        y = side - 1 - y;
      }
      std::swap(x, y);
    }
    x += side * right;
    y += side * up;
    step /= 4;
  }
  return y * SkyTable::kSide + x;
}

// All cells that stand for a part of the sky, neighbours next to each other.
const std::vector<std::uint32_t>& SkyAlongCurve() {
  static const std::vector<std::uint32_t> cells = [] {
    std::vector<std::uint32_t> order;
    for (std::uint32_t step = 0; step < SkyTable::kCells; ++step) {
      const std::uint32_t cell = HilbertCell(step);
      if (SkyTable::SolidAngleSr(cell) > 0.0) order.push_back(cell);
    }
    return order;
  }();
  return cells;
}

// A point of a cell, which its value stands for; `at` in the unit square.
glm::vec3 DirectionInCell(std::uint32_t cell, const glm::dvec2& at) {
  const glm::dvec2 corner(cell % SkyTable::kSide, cell / SkyTable::kSide);
  const glm::dvec2 point = (corner + at) * (2.0 / SkyTable::kSide) - 1.0;
  const double radius2 = glm::dot(point, point);
  // Beyond the disc's rim lies no sky: the cell's own centre.
  if (!(radius2 < 1.0) || radius2 == 0.0) return glm::vec3(SkyTable::DirectionOfCell(cell));
  const double level = std::sqrt(2.0 - radius2);
  return glm::normalize(glm::vec3(level * point.x, level * point.y, 1.0 - radius2));
}

double Cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// The convex hull of a window as one object sees it.
class Opening {
 public:
  Opening(const Window& window, const BoundingSphere& object) : radius_m_(object.radius_m) {
    glm::dvec3 normal(0.0);
    for (std::size_t i = 0; i < window.polygon_m.size(); ++i) {
      normal +=
          glm::cross(window.polygon_m[i] - window.polygon_m[0],
                     window.polygon_m[(i + 1) % window.polygon_m.size()] - window.polygon_m[0]);
    }
    normal = glm::normalize(normal);
    // Outwards: away from the object.
    if (glm::dot(normal, window.polygon_m[0] - object.centre_m) < 0.0) normal = -normal;
    const auto plane = internal::WallPlane::Through(normal, window.polygon_m[0]);
    std::vector<glm::dvec2> corners;
    for (const glm::dvec3& corner : window.polygon_m) corners.push_back(plane.Project(corner));
    outwards_ = normal;
    const std::vector<glm::dvec2> hull = ConvexHull(corners);
    const glm::dvec2 centre = plane.Project(object.centre_m);
    double beyond_m = 0.0;  // How far the centre's foot is beyond the farthest edge.
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const glm::dvec2 side = glm::normalize(hull[(i + 1) % hull.size()] - hull[i]);
      beyond_m = std::max(beyond_m, -Cross(side, centre - hull[i]));
      const glm::dvec2 foot = hull[i] + glm::dot(side, centre - hull[i]) * side;
      // (right, up, normal) is right-handed.
      edges_.push_back(
          {side.x * plane.right + side.y * plane.up, object.centre_m - plane.Lift(foot)});
    }
    const double height_m = plane.offset_m - glm::dot(normal, object.centre_m);
    meets_object_ = std::hypot(height_m, beyond_m) < radius_m_;
  }

  // Whether some direction no farther than a cell's radius leads from the sphere through the hull.
  bool LetsThrough(const glm::dvec3& direction) const {
    if (meets_object_) return true;
    if (glm::dot(outwards_, direction) < -kCellRadiusRad) return false;
    return std::all_of(edges_.begin(), edges_.end(), [&](const Edge& edge) {
      // Across the edge as seen along the direction, to the hull's side.
      const glm::dvec3 inwards = glm::cross(direction, edge.along);
      return glm::dot(inwards, edge.to_centre_m) + radius_m_ * glm::length(inwards) +
                 kCellRadiusRad * (glm::length(edge.to_centre_m) + radius_m_) >=
             0.0;
    });
  }

 private:
  struct Edge {
    glm::dvec3 along;        // Unit, counter-clockwise around `outwards_`.
    glm::dvec3 to_centre_m;  // From the nearest point of its line to the sphere's centre.
  };
  double radius_m_;
  glm::dvec3 outwards_{0.0};
  std::vector<Edge> edges_;
  bool meets_object_ = false;
};

void RequireSphere(const BoundingSphere& sphere) {
  const bool finite = std::isfinite(sphere.centre_m.x) && std::isfinite(sphere.centre_m.y) &&
                      std::isfinite(sphere.centre_m.z) && std::isfinite(sphere.radius_m);
  if (!finite || !(sphere.radius_m >= 0.0)) {
    throw std::invalid_argument(std::string("daylight: bounding sphere of radius ") +
                                std::to_string(sphere.radius_m) +
                                " m: expected a finite centre and a radius >= 0");
  }
}

void RequireSky(std::span<const glm::vec3> sky_radiance) {
  if (sky_radiance.size() != SkyTable::kCells) {
    throw std::invalid_argument(std::string("daylight: sky table of ") +
                                std::to_string(sky_radiance.size()) + " cells: expected " +
                                std::to_string(SkyTable::kCells));
  }
  for (std::size_t cell = 0; cell < sky_radiance.size(); ++cell) {
    for (int channel = 0; channel < 3; ++channel) {
      const float value = sky_radiance[cell][channel];
      if (!(value >= 0.0f && value <= std::numeric_limits<float>::max())) {
        throw std::invalid_argument(std::string("daylight: sky table's cell ") +
                                    std::to_string(cell) + " channel " + std::to_string(channel) +
                                    " is " + std::to_string(value) +
                                    ": expected a finite radiance >= 0");
      }
    }
  }
}

// Running sums of the brightness of cells in their order.
std::vector<double> RunningSums(std::span<const glm::vec3> sky_radiance,
                                std::span<const std::uint32_t> cells) {
  std::vector<double> sums(cells.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    sum += Brightness(sky_radiance[cells[i]]);
    sums[i] = sum;
  }
  return sums;
}

// The first cell whose running sum is above a share in [0, 1) of all.
std::size_t PickCell(const std::vector<double>& sums, double share) {
  const auto at = std::upper_bound(sums.begin(), sums.end(), share * sums.back());
  if (at != sums.end()) return static_cast<std::size_t>(at - sums.begin());
  // Rounding: the last one that has any light.
  return static_cast<std::size_t>(std::lower_bound(sums.begin(), sums.end(), sums.back()) -
                                  sums.begin());
}

}  // namespace

BoundingSphere BoundingSphereOf(std::span<const glm::vec3> points_m) {
  if (points_m.empty()) throw std::invalid_argument("bounding sphere: no points");
  glm::dvec3 lower(points_m[0]);
  glm::dvec3 upper = lower;
  for (const glm::vec3& point : points_m) {
    lower = glm::min(lower, glm::dvec3(point));
    upper = glm::max(upper, glm::dvec3(point));
  }
  BoundingSphere sphere{0.5 * (lower + upper), 0.0};
  for (const glm::vec3& point : points_m) {
    const double distance_m = glm::distance(glm::dvec3(point), sphere.centre_m);
    if (!std::isfinite(distance_m)) {
      throw std::invalid_argument("bounding sphere: a point is not finite");
    }
    sphere.radius_m = std::max(sphere.radius_m, distance_m);
  }
  return sphere;
}

void DaylightSamplingOptions::Validate() const {
  if (samples < 1 || samples > 65536) {
    throw std::invalid_argument("samples is " + std::to_string(samples) + ": expected 1 to 65536");
  }
}

std::vector<glm::vec3> SkyRadianceTable(const Lighting& lighting,
                                        std::span<const std::shared_ptr<const SkyShape>> shapes) {
  if (lighting.sky.size() != shapes.size()) {
    throw std::invalid_argument(std::string("daylight: ") + std::to_string(lighting.sky.size()) +
                                " sky components, and " + std::to_string(shapes.size()) +
                                " shapes: expected as many");
  }
  std::vector<glm::vec3> table(SkyTable::kCells, glm::vec3(0.0f));
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const glm::vec3 irradiance(lighting.sky[k].irradiance_rgb);
    for (const std::uint32_t cell : SkyAlongCurve()) {
      table[cell] += irradiance * shapes[k]->Radiance(glm::vec3(SkyTable::DirectionOfCell(cell)));
    }
  }
  return table;
}

DaylightSampler::DaylightSampler(std::span<const Window> windows,
                                 const BoundingSphere& object,
                                 const DaylightSamplingOptions& options)
    : options_(options) {
  options_.Validate();
  RequireSphere(object);
  std::vector<Opening> openings;
  for (const Window& window : windows) {
    window.Validate();
    openings.emplace_back(window, object);
  }
  const bool whole = options_.restriction == DaylightRestriction::kWholeSky;
  through_window_.assign(SkyTable::kCells, false);
  for (const std::uint32_t cell : SkyAlongCurve()) {
    const glm::dvec3 direction = SkyTable::DirectionOfCell(cell);
    through_window_[cell] =
        whole || std::any_of(openings.begin(), openings.end(), [&](const Opening& opening) {
          return opening.LetsThrough(direction);
        });
    if (through_window_[cell]) kept_.push_back(cell);
  }
}

glm::vec3 DaylightSampler::LargestIrradiance(std::span<const glm::vec3> sky_radiance) const {
  RequireSky(sky_radiance);
  glm::dvec3 sum(0.0);
  for (const std::uint32_t cell : kept_) {
    sum += SkyTable::SolidAngleSr(cell) * glm::dvec3(sky_radiance[cell]);
  }
  return glm::vec3(sum);
}

DaylightSamples DaylightSampler::Draw(std::span<const glm::vec3> sky_radiance) const {
  RequireSky(sky_radiance);
  DaylightSamples drawn;
  if (kept_.empty()) {
    drawn.why_none = "no window lets sky through to the object";
    return drawn;
  }
  const std::vector<std::uint32_t>& sky = SkyAlongCurve();
  const std::vector<double> kept_sums = RunningSums(sky_radiance, kept_);
  const double kept_sum = kept_sums.back();
  if (!(kept_sum > 0.0)) {
    drawn.why_none = "the sky that the object can see is black";
    return drawn;
  }
  const bool until_kept = options_.restriction == DaylightRestriction::kRejection;
  const std::vector<double> sky_sums =
      kept_.size() == sky.size() ? kept_sums : RunningSums(sky_radiance, sky);
  drawn.sky_share = kept_sum / sky_sums.back();

  const glm::dvec2 rotation = RotationOf(options_.seed, 0);
  const auto count = static_cast<std::size_t>(options_.samples);
  std::vector<std::uint32_t> cells;
  if (until_kept) {
    // Where nearly nothing comes through, fewer samples must suffice.
    const std::size_t most_draws = 4096 * count;
    for (std::size_t k = 0; k < most_draws && cells.size() < count; ++k) {
      const double share =
          Fraction(rotation.x + static_cast<double>(k) * (std::numbers::phi - 1.0));
      const std::uint32_t cell = sky[PickCell(sky_sums, share)];
      if (through_window_[cell]) cells.push_back(cell);
    }
    if (cells.empty()) {
      drawn.why_none = "no draw from the entire sky came through a window";
      return drawn;
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const double share = (static_cast<double>(i) + rotation.x) / static_cast<double>(count);
      cells.push_back(kept_[PickCell(kept_sums, share)]);
    }
  }
  // Radiance over the density by solid angle: brightness over its integral, shared among the draws.
  const double integral = kept_sum * SkyTable::SolidAngleSr(sky.front());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const glm::vec3& radiance = sky_radiance[cells[i]];
    const double weight = integral / (Brightness(radiance) * static_cast<double>(cells.size()));
    drawn.samples.push_back({DirectionInCell(cells[i], R2Point(static_cast<int>(i), rotation)),
                             static_cast<float>(weight) * radiance});
  }
  return drawn;
}

}  // namespace pleinair
