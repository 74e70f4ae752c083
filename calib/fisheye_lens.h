// Fish-eye lenses, both ways, 90 degrees from the axis and beyond. With theta the angle to the
// optical axis and f the focal length in pixels, the distance r to the principal point is
//   equidistant    r = f theta
//   equisolid      r = 2 f sin(theta / 2)
//   stereographic  r = 2 f tan(theta / 2)
//   opencv         r = f theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//   (cv::fisheye)
// For the camera's orientation in the world see fisheye_camera.h.
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

enum class FisheyeModel { kEquidistant, kEquisolid, kStereographic, kOpenCv };

// "equidistant", "equisolid", "stereographic", "opencv".
const char* FisheyeModelName(FisheyeModel model);
std::optional<FisheyeModel> FisheyeModelFromName(std::string_view name);

// Integer pixel coordinates are pixel centres, as for every camera.
struct FisheyeIntrinsics {
  FisheyeModel model = FisheyeModel::kEquidistant;
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  std::array<double, 4> distortion{};             // k1..k4; zero except for kOpenCv.
  double max_angle_rad = 0.5 * std::numbers::pi;  // From the axis: half the field of view.

  bool operator==(const FisheyeIntrinsics&) const = default;
};

// Returns the ideal lens whose centred circle of `field_of_view_rad` (full angle) is as wide as the
// picture's shorter side. Throws std::invalid_argument for kOpenCv, and as FisheyeLens does.
FisheyeIntrinsics CentredFisheye(FisheyeModel model,
                                 double field_of_view_rad,
                                 int width_px,
                                 int height_px);

// Projection with its set-up done. Safe from any thread.
//
// Frame     the camera's (OpenCV): x right in the picture, y down, z along the optical axis. A
//           picture that is mirrored ("as a map") needs a mirroring camera_from_world, see
//           fisheye_camera.h.
// Validity  directions up to MaxAngleRad() from the axis. There the mapping is one-to-one, and
//           projecting a direction that came from a pixel gives that pixel back within 1e-6 px, for
//           pixels up to 1e5 px from the principal point. Outside of it both functions return none.
//           The picture's borders are ignored.
class FisheyeLens {
 public:
  // 179.94 deg from the axis. The direction straight backwards is a circle in the picture, not a
  // point.
  static constexpr double kLargestAngleRad = std::numbers::pi - 1e-3;

  // Throws std::invalid_argument naming the field and its value. Refused are a size, focal length
  // or angle that is not positive, a value that is not finite, and distortion for a model that has
  // none.
  explicit FisheyeLens(const FisheyeIntrinsics& intrinsics);

  // Image point of a camera-frame direction of any length; none outside the validity.
  std::optional<glm::dvec2> ProjectToPixel(const glm::dvec3& direction_camera) const;

  // Unit camera-frame direction through an image point; none where no valid direction leads there.
  std::optional<glm::dvec3> DirectionFromPixel(const glm::dvec2& pixel) const;

  // Solid angle in steradians of the pixel around an image point, as if all of it were valid. So
  // pixels with a valid centre tile the field of view. 0 where the point itself is not valid.
  // Accuracy  1e-4 relative for a focal length of 10 px or more, up to 90 deg on all sides of the
  //           pixel. Near the end of the validity, where the model folds, that of the pixel's
  //           middle.
  double PixelSolidAngleSr(const glm::dvec2& pixel) const;

  // The validity's end: the stated angle, or where the distortion folds, or kLargestAngleRad.
  double MaxAngleRad() const { return max_angle_rad_; }
  const FisheyeIntrinsics& Intrinsics() const { return intrinsics_; }

 private:
  // The distance to the principal point for f = 1, and its derivative by the angle.
  double Radius(double angle_rad) const;
  double RadiusSlope(double angle_rad) const;
  // The angle in [0, model_limit_rad_] for such a distance; none beyond.
  std::optional<double> Angle(double radius) const;
  // d(solid angle) / d(area in px^2); none where the model ends.
  std::optional<double> SolidAngleDensity(const glm::dvec2& pixel) const;

  FisheyeIntrinsics intrinsics_;
  double model_limit_rad_;  // Where the model itself stops being one-to-one.
  double max_angle_rad_;
};

}  // namespace pleinair
