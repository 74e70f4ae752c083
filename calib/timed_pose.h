// A camera's pose at a time, and what lies between two.
#pragma once

#include <string>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/utc_time.h"

namespace pleinair {

struct TimedPose {
  UtcTime time{};
  glm::dmat4 camera_from_world{1.0};
};

// A small motion from one pose to another, in the first one's camera axes. It does not depend on
// where the world's origin is.
struct PoseChange {
  glm::dvec3 moved_m{0.0};     // Of the camera's centre.
  glm::dvec3 turned_rad{0.0};  // Axis times angle: a direction v of the first camera is, in the
                               // second, exp(turned) v.
};
PoseChange ChangeBetween(const glm::dmat4& from, const glm::dmat4& to);
// `from` after `change`: the inverse of the above.
glm::dmat4 Changed(const glm::dmat4& from, const PoseChange& change);

// Of any two times: their difference in ticks may be too large for these.
double SecondsFromTo(UtcTime from, UtcTime to);

// The camera moves straight and turns about one axis, both at constant speed. Before the first and
// after the second pose it stands still. The two may be of one time: the second one holds there.
glm::dmat4 PoseBetween(const TimedPose& first, const TimedPose& second, UtcTime time);

// What is expected where `camera_from_world` is not rigid (to 1e-5: poses are written with six
// digits or more), a mirror image or not finite; empty where it is a pose.
std::string FaultOfPose(const glm::dmat4& camera_from_world);

}  // namespace pleinair
