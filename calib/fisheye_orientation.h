// The orientation of a fish-eye camera in the world, from marks of known world directions, or from
// the sun's own image at known times.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "calib/fisheye_camera.h"
#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// One thing in the picture: its direction in the camera and in the world. Any length but 0.
struct DirectionPair {
  glm::dvec3 direction_camera;
  glm::dvec3 direction_world;
};

enum class Handedness { kRightHanded, kMirrored };

// The orientation, and how well pairs agree with it.
struct OrientationFit {
  glm::dmat3 world_from_camera{1.0};
  double rms_rad = 0.0;              // Over the inliers.
  std::vector<double> residual_rad;  // One for each pair, in the order given.
  std::vector<bool> counts;          // False: a mark that does not fit the others.
};

// Limits of the fit.
struct OrientationOptions {
  Handedness handedness = Handedness::kRightHanded;
  // A mark farther off than this does not count: a wrong match.
  double outlier_rad = 0.035;  // 2 degrees.
};

// Returns the rotation (or mirrored rotation) from camera to world directions. It is the one that
// most pairs agree on (each two propose one), refined by least squares over these.
//
// Source   Kabsch, Acta Crystallographica A32, 1976; Wahba's problem by singular values.
// Throws   std::invalid_argument: fewer than two pairs, a direction of no length;
//          std::runtime_error where the orientation cannot be determined: all that agree lie within
//          kLeastSpreadRad of one line, or no two agree.
OrientationFit FitOrientation(std::span<const DirectionPair> pairs,
                              const OrientationOptions& options = {});
inline constexpr double kLeastSpreadRad = 0.05;

// The same from the world's up in camera coordinates (the optical axis of a levelled camera) and
// one sun or mark. Up is kept exactly; the mark gives north. residual_rad has one entry: the error
// of the mark's height above the horizon.
// Throws   as FitOrientation; std::runtime_error where the mark is within kLeastSpreadRad of up.
OrientationFit OrientationFromUp(const glm::dvec3& up_camera,
                                 const DirectionPair& mark,
                                 Handedness handedness = Handedness::kRightHanded);

// Returns why an orientation is not credible: it is off by more than kLargestCredibleOffRad (a
// camera that is levelled by eye, a lens that is off at its rim), only two of several marks agree,
// as they do by chance, or the axis is further than kLowestCredibleAxisRad from the zenith. Another
// place or time of the sun gives such fits, and a picture that is mirrored. Empty where nothing is
// wrong.
inline constexpr double kLargestCredibleOffRad = 0.087;  // 5 degrees.
inline constexpr double kLowestCredibleAxisRad = 1.66;   // 95 degrees: out of a window.
std::string DoubtAbout(const OrientationFit& fit);
// From the optical axis to the zenith.
double AxisFromZenithRad(const OrientationFit& fit);

// Apparent direction of the sun: refracted as in the standard atmosphere at the site's height.
glm::dvec3 ApparentSunDirectionEnu(const Site& site, UtcTime time);

// The sun's own image.
struct SunImage {
  glm::dvec3 direction_camera{0.0, 0.0, 1.0};  // Direction of its centre of light, unit.
  double angular_radius_rad = 0.0;             // Radius of a disc of the same solid angle.
  bool clipped = false;                        // A flat top: light above it is not known.
};

// Finds the brightest thing in a sky picture, where it is small enough for the sun (kLargestSunRad)
// and isolated. It is a set of connected pixels above half of the brightest one's light, and must
// hold three quarters of all such light. None otherwise (no sun, or clipped clouds).
std::optional<SunImage> FindSunImage(const RgbImage& radiance, const FisheyeLens& lens);
inline constexpr double kLargestSunRad = 0.09;  // 5 degrees: clipped aureole included.

}  // namespace pleinair
