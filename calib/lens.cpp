#include "calib/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "calib/internal/check_number.h"
#include "calib/internal/distortion.h"
#include "calib/internal/polynomial.h"

namespace pleinair {
namespace {

// 89.9994 deg from the axis: distortion that is valid so far out is called valid no farther.
constexpr double kMaxRadius = 1e5;
constexpr double kMaxPixel = 1e8;
constexpr int kMaxCoverSidePx = 16384;

// In the frame (radial, tangential) at (r, theta), theta counted from the direction (p2, p1), with
// p = |(p1, p2)| the distortion's Jacobian is symmetric,
//   [ d(r) + 6 p r cos(theta)      -2 p r sin(theta)       ]
//   [ -2 p r sin(theta)            D(r) + 2 p r cos(theta) ]
// with D = 1 + k1 r^2 + k2 r^4 + k3 r^6 and d = (r D)'. The part with p has no eigenvalue below
// -6 p r, so the sum is positive definite while min(d, D) > 6 p r. The mapping is then the gradient
// of a strictly convex function on a disc: one-to-one. Where d <= D, the bound is exact: barrel
// distortion folds on the side away from (p2, p1).
double RadiusOfValidity(const std::array<double, 5>& distortion) {
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double tangential = 6.0 * std::hypot(p1, p2);
  const std::array<double, 7> radial_slope{1.0, -tangential, 3 * k1, 0.0, 5 * k2, 0.0, 7 * k3};
  const std::array<double, 7> magnification{1.0, -tangential, k1, 0.0, k2, 0.0, k3};
  return std::min(PositiveUpTo(radial_slope, kMaxRadius), PositiveUpTo(magnification, kMaxRadius));
}

struct Distorted {
  glm::dvec2 point;
  // Symmetric Jacobian.
  double dxx;
  double dxy;
  double dyy;
};

Distorted Distort(const std::array<double, 5>& distortion, const glm::dvec2& point) {
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double x = point.x;
  const double y = point.y;
  const double s = x * x + y * y;
  const double magnification = 1.0 + s * (k1 + s * (k2 + s * k3));
  const double slope = 2.0 * (k1 + s * (2.0 * k2 + s * 3.0 * k3));  // 2 dD/d(r^2).
  const auto [distorted_x, distorted_y] = DistortedPoint(distortion, x, y);
  return {{distorted_x, distorted_y},
          magnification + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
          slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y,
          magnification + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x};
}

// The radius in [0, limit] whose radially distorted one is `distorted_radius`, or the limit. r D(r)
// rises over the entire interval.
double UndistortRadius(const std::array<double, 5>& distortion,
                       double distorted_radius,
                       double limit) {
  // Not a structured binding: clang 14 lets no lambda capture one.
  const double k1 = distortion[0];
  const double k2 = distortion[1];
  const double k3 = distortion[4];
  const auto radial = [&](double r) {
    const double s = r * r;
    return r * (1.0 + s * (k1 + s * (k2 + s * k3)));
  };
  if (!(radial(limit) > distorted_radius)) return limit;
  double low = 0.0;
  double high = limit;
  double radius = std::min(distorted_radius, 0.5 * limit);
  // A start for Newton's method in the plane: 1e-6 is near enough for its quadratic end.
  while (high - low > 1e-6 * high) {
    const double error = radial(radius) - distorted_radius;
    (error < 0.0 ? low : high) = radius;
    const double s = radius * radius;
    const double slope = 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3));
    const double newton = radius - error / slope;
    if (std::abs(newton - radius) <= 1e-9 * radius) break;
    radius = newton > low && newton < high ? newton : 0.5 * (low + high);
  }
  return radius;
}

// Only distortion makes the set-up worth keeping; a caller that goes back and forth between a
// distorted camera and its undistorted cover finds it still there.
Lens KeptLens(const CameraIntrinsics& intrinsics) {
  if (!intrinsics.HasDistortion()) return Lens(intrinsics);
  thread_local std::optional<Lens> lens;
  if (!lens || !(lens->Intrinsics() == intrinsics)) lens.emplace(intrinsics);
  return *lens;
}

}  // namespace

Lens::Lens(const CameraIntrinsics& intrinsics)
    : intrinsics_(intrinsics), valid_radius_(std::numeric_limits<double>::infinity()) {
  RequirePositive("width_px", intrinsics.width_px);
  RequirePositive("height_px", intrinsics.height_px);
  RequirePositive("fx_px", intrinsics.fx_px);
  RequirePositive("fy_px", intrinsics.fy_px);
  RequireFinite("cx_px", intrinsics.cx_px);
  RequireFinite("cy_px", intrinsics.cy_px);
  for (const double coefficient : intrinsics.distortion) RequireFinite("distortion", coefficient);
  if (intrinsics.HasDistortion()) valid_radius_ = RadiusOfValidity(intrinsics.distortion);
}

std::optional<glm::dvec2> Lens::ProjectToPixel(const glm::dvec3& point_camera) const {
  if (!(point_camera.z > 0.0)) return std::nullopt;
  glm::dvec2 point = glm::dvec2(point_camera) / point_camera.z;
  if (intrinsics_.HasDistortion()) {
    if (!(std::hypot(point.x, point.y) < valid_radius_)) return std::nullopt;
    point = Distort(intrinsics_.distortion, point).point;
  }
  const glm::dvec2 pixel(intrinsics_.fx_px * point.x + intrinsics_.cx_px,
                         intrinsics_.fy_px * point.y + intrinsics_.cy_px);
  if (!(std::abs(pixel.x) <= kMaxPixel && std::abs(pixel.y) <= kMaxPixel)) return std::nullopt;
  return pixel;
}

std::optional<glm::dvec3> Lens::DirectionFromPixel(const glm::dvec2& pixel) const {
  if (!(std::abs(pixel.x) <= kMaxPixel && std::abs(pixel.y) <= kMaxPixel)) return std::nullopt;
  const glm::dvec2 target((pixel.x - intrinsics_.cx_px) / intrinsics_.fx_px,
                          (pixel.y - intrinsics_.cy_px) / intrinsics_.fy_px);
  if (!intrinsics_.HasDistortion()) return glm::normalize(glm::dvec3(target, 1.0));

  const double target_radius = std::hypot(target.x, target.y);
  if (target_radius == 0.0) return glm::dvec3(0.0, 0.0, 1.0);
  const double start = UndistortRadius(intrinsics_.distortion, target_radius, valid_radius_);
  // Just inside: at the rim itself the Jacobian may be singular.
  glm::dvec2 point = target / target_radius * std::min(start, valid_radius_ * (1.0 - 1e-6));
  // So that rounding on the way back does not carry a direction over the rim.
  const double inner_radius = valid_radius_ * (1.0 - 1e-12);

  // Newton's method; the error's length falls in every step. Halving the step keeps it in the disc
  // where the Jacobian is positive definite. Towards the rim it converges more slowly (by a factor
  // of four in the error), never to a wrong point.
  const auto error_px = [&](const glm::dvec2& error) {
    return std::hypot(intrinsics_.fx_px * error.x, intrinsics_.fy_px * error.y);
  };
  Distorted distorted = Distort(intrinsics_.distortion, point);
  glm::dvec2 error = distorted.point - target;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double determinant = distorted.dxx * distorted.dyy - distorted.dxy * distorted.dxy;
    if (!(determinant > 0.0)) break;
    const glm::dvec2 step = glm::dvec2(distorted.dxy * error.y - distorted.dyy * error.x,
                                       distorted.dxy * error.x - distorted.dxx * error.y) /
                            determinant;
    bool better = false;
    for (double length = 1.0; length > 1e-6 && !better; length *= 0.5) {
      const glm::dvec2 next_point = point + length * step;
      if (!(std::hypot(next_point.x, next_point.y) < inner_radius)) continue;
      const Distorted next = Distort(intrinsics_.distortion, next_point);
      const glm::dvec2 next_error = next.point - target;
      if (!(glm::dot(next_error, next_error) < glm::dot(error, error))) continue;
      better = true;
      point = next_point;
      distorted = next;
      error = next_error;
    }
    if (!better) break;
  }
  // A tenth of what is promised; the rest is left to the rounding of whoever uses the direction.
  if (!(error_px(error) <= 1e-7)) return std::nullopt;
  return glm::normalize(glm::dvec3(point, 1.0));
}

std::optional<glm::dvec2> ProjectToPixel(const CameraIntrinsics& intrinsics,
                                         const glm::dvec3& point_camera) {
  return KeptLens(intrinsics).ProjectToPixel(point_camera);
}

std::optional<glm::dvec3> DirectionFromPixel(const CameraIntrinsics& intrinsics,
                                             const glm::dvec2& pixel) {
  return KeptLens(intrinsics).DirectionFromPixel(pixel);
}

std::optional<glm::dvec2> ProjectToPixel(const Camera& camera, const glm::dvec3& point_world_m) {
  const glm::dvec3 point_camera(camera.camera_from_world * glm::dvec4(point_world_m, 1.0));
  if (!(point_camera.z > 0.0)) return std::nullopt;
  return ProjectToPixel(camera.intrinsics, point_camera);
}

CameraIntrinsics UndistortedCover(const CameraIntrinsics& intrinsics) {
  const Lens lens(intrinsics);
  if (!intrinsics.HasDistortion()) return intrinsics;

  glm::dvec2 lower(std::numeric_limits<double>::infinity());
  glm::dvec2 upper(-std::numeric_limits<double>::infinity());
  const auto cover = [&](const glm::dvec3& direction) {
    const glm::dvec2 undistorted(intrinsics.fx_px * direction.x / direction.z + intrinsics.cx_px,
                                 intrinsics.fy_px * direction.y / direction.z + intrinsics.cy_px);
    lower = glm::min(lower, undistorted);
    upper = glm::max(upper, undistorted);
  };
  const auto cover_pixel = [&](double u, double v) {
    if (const auto direction = lens.DirectionFromPixel({u, v})) cover(*direction);
  };
  // The mapping is one-to-one and continuous. So the visible directions end at the picture's
  // outline, or at the fold inside the picture. Steps of half a pixel: between them a smooth
  // outline deviates by far less than the margin.
  const double right = intrinsics.width_px - 0.5;
  const double bottom = intrinsics.height_px - 0.5;
  for (int i = 0; i <= 2 * intrinsics.width_px; ++i) {
    cover_pixel(0.5 * i - 0.5, -0.5);
    cover_pixel(0.5 * i - 0.5, bottom);
  }
  for (int i = 0; i <= 2 * intrinsics.height_px; ++i) {
    cover_pixel(-0.5, 0.5 * i - 0.5);
    cover_pixel(right, 0.5 * i - 0.5);
  }
  constexpr int kRimPoints = 8192;
  const double rim = lens.ValidRadius() * (1.0 - 1e-9);
  for (int i = 0; i < kRimPoints; ++i) {
    const double angle = 2.0 * 3.14159265358979323846 * i / kRimPoints;
    const glm::dvec3 direction(rim * std::cos(angle), rim * std::sin(angle), 1.0);
    const auto pixel = lens.ProjectToPixel(direction);
    if (pixel && pixel->x >= -0.5 && pixel->x <= right && pixel->y >= -0.5 && pixel->y <= bottom) {
      cover(direction);
    }
  }

  // Pixel x covers [x - 0.5, x + 0.5].
  const glm::dvec2 first = glm::floor(lower - 1.0 + 0.5);
  const glm::dvec2 size = glm::ceil(upper + 1.0 - 0.5) - first + 1.0;
  if (!(size.x <= kMaxCoverSidePx && size.y <= kMaxCoverSidePx && size.x >= 1 && size.y >= 1)) {
    throw std::invalid_argument("distortion: its undistorted picture would have " +
                                std::to_string(size.x) + " x " + std::to_string(size.y) +
                                " pixels, expected at most " + std::to_string(kMaxCoverSidePx) +
                                " a side");
  }
  CameraIntrinsics result = intrinsics;
  result.width_px = static_cast<int>(size.x);
  result.height_px = static_cast<int>(size.y);
  result.cx_px -= first.x;
  result.cy_px -= first.y;
  result.distortion = {};
  return result;
}

}  // namespace pleinair
