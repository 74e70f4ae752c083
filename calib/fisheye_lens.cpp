#include "calib/fisheye_lens.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/internal/check_number.h"
#include "calib/internal/polynomial.h"

namespace pleinair {
namespace {

constexpr std::array<const char*, 4> kModelNames{
    "equidistant", "equisolid", "stereographic", "opencv"};

// So that the rounding of a direction on its way back does not carry it over the rim; far below a
// millionth of a pixel for any picture.
constexpr double kRimSlack = 1e-12;

// r(theta) / f of an ideal lens.
double IdealRadius(FisheyeModel model, double angle_rad) {
  switch (model) {
    case FisheyeModel::kEquisolid:
      return 2.0 * std::sin(0.5 * angle_rad);
    case FisheyeModel::kStereographic:
      return 2.0 * std::tan(0.5 * angle_rad);
    case FisheyeModel::kEquidistant:
    case FisheyeModel::kOpenCv:
      return angle_rad;
  }
  return angle_rad;
}

// sin(x) / x.
double Sinc(double x) { return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x; }

}  // namespace

const char* FisheyeModelName(FisheyeModel model) {
  return kModelNames[static_cast<std::size_t>(model)];
}

std::optional<FisheyeModel> FisheyeModelFromName(std::string_view name) {
  for (std::size_t i = 0; i < kModelNames.size(); ++i) {
    if (name == kModelNames[i]) return static_cast<FisheyeModel>(i);
  }
  return std::nullopt;
}

FisheyeIntrinsics CentredFisheye(FisheyeModel model,
                                 double field_of_view_rad,
                                 int width_px,
                                 int height_px) {
  if (model == FisheyeModel::kOpenCv) {
    throw std::invalid_argument("model opencv: expected a calibration, not a field of view alone");
  }
  RequirePositive("field_of_view_rad", field_of_view_rad);
  RequirePositive("width_px", width_px);
  RequirePositive("height_px", height_px);
  FisheyeIntrinsics lens;
  lens.model = model;
  lens.width_px = width_px;
  lens.height_px = height_px;
  lens.cx_px = 0.5 * (width_px - 1);
  lens.cy_px = 0.5 * (height_px - 1);
  lens.max_angle_rad = std::min(0.5 * field_of_view_rad, FisheyeLens::kLargestAngleRad);
  lens.fx_px = 0.5 * std::min(width_px, height_px) / IdealRadius(model, lens.max_angle_rad);
  lens.fy_px = lens.fx_px;
  return lens;
}

FisheyeLens::FisheyeLens(const FisheyeIntrinsics& intrinsics)
    : intrinsics_(intrinsics), model_limit_rad_(kLargestAngleRad) {
  RequirePositive("width_px", intrinsics.width_px);
  RequirePositive("height_px", intrinsics.height_px);
  RequirePositive("fx_px", intrinsics.fx_px);
  RequirePositive("fy_px", intrinsics.fy_px);
  RequireFinite("cx_px", intrinsics.cx_px);
  RequireFinite("cy_px", intrinsics.cy_px);
  RequirePositive("max_angle_rad", intrinsics.max_angle_rad);
  for (const double coefficient : intrinsics.distortion) {
    RequireFinite("distortion", coefficient);
    if (intrinsics.model != FisheyeModel::kOpenCv && coefficient != 0.0) {
      throw std::invalid_argument("distortion " + std::to_string(coefficient) +
                                  ": expected 0, as " + FisheyeModelName(intrinsics.model) +
                                  " has none");
    }
  }
  if (intrinsics.model == FisheyeModel::kOpenCv) {
    const auto [k1, k2, k3, k4] = intrinsics.distortion;
    const std::array<double, 9> slope{1.0, 0.0, 3 * k1, 0.0, 5 * k2, 0.0, 7 * k3, 0.0, 9 * k4};
    model_limit_rad_ = PositiveUpTo(slope, kLargestAngleRad);
  }
  max_angle_rad_ = std::min(intrinsics.max_angle_rad, model_limit_rad_);
}

double FisheyeLens::Radius(double angle_rad) const {
  if (intrinsics_.model != FisheyeModel::kOpenCv) return IdealRadius(intrinsics_.model, angle_rad);
  const auto& [k1, k2, k3, k4] = intrinsics_.distortion;
  const double s = angle_rad * angle_rad;
  return angle_rad * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4))));
}

double FisheyeLens::RadiusSlope(double angle_rad) const {
  switch (intrinsics_.model) {
    case FisheyeModel::kEquidistant:
      return 1.0;
    case FisheyeModel::kEquisolid:
      return std::cos(0.5 * angle_rad);
    case FisheyeModel::kStereographic: {
      const double cosine = std::cos(0.5 * angle_rad);
      return 1.0 / (cosine * cosine);
    }
    case FisheyeModel::kOpenCv:
      break;
  }
  const auto& [k1, k2, k3, k4] = intrinsics_.distortion;
  const double s = angle_rad * angle_rad;
  return 1.0 + s * (3 * k1 + s * (5 * k2 + s * (7 * k3 + s * 9 * k4)));
}

std::optional<double> FisheyeLens::Angle(double radius) const {
  if (!(radius <= Radius(model_limit_rad_))) return std::nullopt;
  switch (intrinsics_.model) {
    case FisheyeModel::kEquidistant:
      return radius;
    case FisheyeModel::kEquisolid:
      return 2.0 * std::asin(0.5 * radius);
    case FisheyeModel::kStereographic:
      return 2.0 * std::atan(0.5 * radius);
    case FisheyeModel::kOpenCv:
      break;
  }
  // The radius rises over the entire interval: Newton's method, with bisection where a step leaves
  // the bracket.
  double low = 0.0;
  double high = model_limit_rad_;
  double angle = std::min(radius, 0.5 * model_limit_rad_);
  for (int iteration = 0; iteration < 200; ++iteration) {
    const double error = Radius(angle) - radius;
    if (error == 0.0) break;
    (error < 0.0 ? low : high) = angle;
    double next = angle - error / RadiusSlope(angle);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (!(next > low && next < high) || next == angle) break;
    angle = next;
  }
  return angle;
}

std::optional<glm::dvec2> FisheyeLens::ProjectToPixel(const glm::dvec3& direction_camera) const {
  const double across = std::hypot(direction_camera.x, direction_camera.y);
  const double angle = std::atan2(across, direction_camera.z);
  // Negated to catch NaN; a direction of no length has no angle.
  if (!(angle <= max_angle_rad_ * (1.0 + kRimSlack)) || !std::isfinite(across) ||
      (across == 0.0 && !(direction_camera.z > 0.0))) {
    return std::nullopt;
  }
  if (across == 0.0) return glm::dvec2(intrinsics_.cx_px, intrinsics_.cy_px);
  const double scale = Radius(angle) / across;
  return glm::dvec2(intrinsics_.cx_px + intrinsics_.fx_px * scale * direction_camera.x,
                    intrinsics_.cy_px + intrinsics_.fy_px * scale * direction_camera.y);
}

std::optional<glm::dvec3> FisheyeLens::DirectionFromPixel(const glm::dvec2& pixel) const {
  const double x = (pixel.x - intrinsics_.cx_px) / intrinsics_.fx_px;
  const double y = (pixel.y - intrinsics_.cy_px) / intrinsics_.fy_px;
  const double radius = std::hypot(x, y);
  const double rim = Radius(max_angle_rad_);
  if (!(radius <= rim * (1.0 + kRimSlack))) return std::nullopt;
  if (radius == 0.0) return glm::dvec3(0.0, 0.0, 1.0);
  const std::optional<double> angle = Angle(std::min(radius, rim));
  if (!angle) return std::nullopt;
  const double scale = std::sin(*angle) / radius;
  return glm::dvec3(scale * x, scale * y, std::cos(*angle));
}

// d(omega) = sin(theta) d(theta) d(phi), d(area) = fx fy r dr d(phi) with r for f = 1.
std::optional<double> FisheyeLens::SolidAngleDensity(const glm::dvec2& pixel) const {
  const double radius = std::hypot((pixel.x - intrinsics_.cx_px) / intrinsics_.fx_px,
                                   (pixel.y - intrinsics_.cy_px) / intrinsics_.fy_px);
  const std::optional<double> angle = Angle(radius);
  if (!angle) return std::nullopt;
  const double slope = RadiusSlope(*angle);
  if (!(slope > 0.0)) return std::nullopt;
  // sin(theta) / r = (sin(theta) / theta) (theta / r), the latter 1 at the centre.
  const double angle_per_radius = radius > 0.0 ? *angle / radius : 1.0;
  return Sinc(*angle) * angle_per_radius / (slope * intrinsics_.fx_px * intrinsics_.fy_px);
}

double FisheyeLens::PixelSolidAngleSr(const glm::dvec2& pixel) const {
  if (!DirectionFromPixel(pixel)) return 0.0;
  // Two Gauss points a side: exact for cubics.
  constexpr double kOffset = 0.5 / std::numbers::sqrt3;
  double sum = 0.0;
  for (const double dy : {-kOffset, kOffset}) {
    for (const double dx : {-kOffset, kOffset}) {
      const auto density = SolidAngleDensity(pixel + glm::dvec2(dx, dy));
      if (!density) return SolidAngleDensity(pixel).value_or(0.0);
      sum += *density;
    }
  }
  return 0.25 * sum;
}

}  // namespace pleinair
