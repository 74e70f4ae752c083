// The motion of camera and virtual objects during a frame's exposure.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// A constant velocity and a constant turn, about the frame's own instant. In world coordinates.
struct SteadyMotion {
  glm::dvec3 centre_m{0.0};       // At that instant; the centre of the turn.
  glm::dvec3 velocity_m_s{0.0};   // Velocity of the centre.
  glm::dvec3 turn_rad_s{0.0};     // Turn rate times the unit axis.
  glm::dmat3 stretch_per_s{0.0};  // Growth and shear, before the turn.

  bool Moves() const;
  // The transform from the place at the frame's instant to that `seconds` later.
  glm::dmat4 After(double seconds) const;
  bool operator==(const SteadyMotion&) const = default;
};

// Returns the motion that gives `now_from_before`, an affine transform of the world, in `seconds`
// above 0. None where that mirrors or flattens, which no motion does.
std::optional<SteadyMotion> MotionOf(const glm::dmat4& now_from_before,
                                     double seconds,
                                     const glm::dvec3& centre_now_m);

// The frame's poses hold at the middle of the exposure of the picture's middle row.
struct ExposureMotion {
  double exposure_s = 0.0;
  double readout_s = 0.0;  // From the first row's exposure to the last one's: a rolling shutter.
  SteadyMotion camera;
  std::vector<SteadyMotion> objects;

  bool Moves() const;
  // The middle of a row's exposure; `row` counts from 0, in pixels' centres.
  double MiddleOfRowS(double row, int height_px) const {
    return readout_s * ((row + 0.5) / height_px - 0.5);
  }
  bool operator==(const ExposureMotion&) const = default;
};

// The nearest object in each pixel of part of the undistorted picture (see UndistortedCover),
// without real surfaces, and its depth along the optical axis.
struct ObjectDepths {
  static constexpr std::int32_t kNone = -1;

  int x_px = 0;  // Position of the images' first pixel in that picture.
  int y_px = 0;
  Image<std::int32_t> object;  // Into ExposureMotion::objects, or kNone. May be empty.
  Image<float> depth_m;
};

// What motion blurs, and the motions.
struct MotionInPicture {
  ExposureMotion motion;
  ObjectDepths objects;
};

}  // namespace pleinair
