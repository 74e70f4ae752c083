// A camera's pose at a time, and interpolation between two.
#pragma once

#include <string>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/utc_time.h"

namespace pleinair {

// A pose at a time, UTC.
struct TimedPose {
  UtcTime time{};
  glm::dmat4 camera_from_world{1.0};
};

// A small motion from one pose to another, in the first one's camera axes. It does not depend on
// the world's origin.
struct PoseChange {
  glm::dvec3 moved_m{0.0};     // Motion of the camera's centre.
  glm::dvec3 turned_rad{0.0};  // Axis times angle: a direction v of the first camera is, in the
                               // second, exp(turned) v.
};
PoseChange ChangeBetween(const glm::dmat4& from, const glm::dmat4& to);
// `from` after `change`: the inverse of the above.
glm::dmat4 Changed(const glm::dmat4& from, const PoseChange& change);

// Difference of any two times: in ticks it may overflow.
double SecondsFromTo(UtcTime from, UtcTime to);

// Interpolates: the camera moves straight and turns about one axis, both at constant speed. It is
// at rest before the first and after the second pose. For two poses of one time, the second holds.
glm::dmat4 PoseBetween(const TimedPose& first, const TimedPose& second, UtcTime time);

// Returns what is expected where `camera_from_world` is not rigid (to 1e-5: poses are written with
// six digits or more), mirrored or not finite; empty for a valid pose.
std::string FaultOfPose(const glm::dmat4& camera_from_world);

}  // namespace pleinair
