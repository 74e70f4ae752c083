#include "calib/timed_pose.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/camera_centre.h"

namespace pleinair {
namespace {

constexpr double kRigidTolerance = 1e-5;

glm::dvec3 RotationVectorOf(const glm::dmat3& rotation) {
  glm::dquat turned = glm::normalize(glm::quat_cast(rotation));
  if (turned.w < 0.0) turned = -turned;  // The shorter way round.
  const glm::dvec3 axis(turned.x, turned.y, turned.z);
  const double sine = glm::length(axis);  // Sine of half the angle.
  // To first order where the angle is too small for its axis: 2 sin(a/2) = a to a^3 / 24.
  if (!(sine > 1e-9)) return 2.0 * axis;
  return axis * (2.0 * std::atan2(sine, turned.w) / sine);
}

glm::dmat3 RotationOf(const glm::dvec3& rotation_vector) {
  const double angle = glm::length(rotation_vector);
  if (!(angle > 0.0)) return glm::dmat3(1.0);
  return glm::mat3_cast(glm::angleAxis(angle, rotation_vector / angle));
}

// Whether it is their angles alone that make axes no rotation.
bool AreUnit(const glm::dmat3& axes) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(glm::dot(axes[axis], axes[axis]) - 1.0) > kRigidTolerance) return false;
  }
  return true;
}

}  // namespace

PoseChange ChangeBetween(const glm::dmat4& from, const glm::dmat4& to) {
  const glm::dmat3 rotation(from);
  return {rotation * (CentreOfCamera(to) - CentreOfCamera(from)),
          RotationVectorOf(glm::dmat3(to) * glm::transpose(rotation))};
}

glm::dmat4 Changed(const glm::dmat4& from, const PoseChange& change) {
  const glm::dmat3 from_rotation(from);
  const glm::dmat3 rotation = RotationOf(change.turned_rad) * from_rotation;
  const glm::dvec3 centre = CentreOfCamera(from) + glm::transpose(from_rotation) * change.moved_m;
  glm::dmat4 pose(rotation);
  pose[3] = glm::dvec4(-(rotation * centre), 1.0);
  return pose;
}

double SecondsFromTo(UtcTime from, UtcTime to) {
  using Ticks = std::chrono::duration<long double, UtcTime::period>;  // Holds 64 bits exactly.
  const Ticks difference = Ticks(to.time_since_epoch()) - Ticks(from.time_since_epoch());
  return std::chrono::duration<double>(difference).count();
}

glm::dmat4 PoseBetween(const TimedPose& first, const TimedPose& second, UtcTime time) {
  if (time >= second.time) return second.camera_from_world;
  if (time <= first.time) return first.camera_from_world;
  const double share = SecondsFromTo(first.time, time) / SecondsFromTo(first.time, second.time);
  PoseChange change = ChangeBetween(first.camera_from_world, second.camera_from_world);
  change.moved_m *= share;
  change.turned_rad *= share;
  return Changed(first.camera_from_world, change);
}

std::string FaultOfPose(const glm::dmat4& camera_from_world) {
  const glm::dmat3 rotation(camera_from_world);
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  double deviation = 0.0;
  bool is_finite = true;
  for (int column = 0; column < 3; ++column) {
    is_finite = is_finite && std::isfinite(camera_from_world[3][column]);
    for (int row = 0; row < 3; ++row) {
      const double off = std::abs(product[column][row] - (column == row ? 1.0 : 0.0));
      is_finite = is_finite && std::isfinite(off);
      deviation = std::max(deviation, off);
    }
  }
  const glm::dvec4 last_row(camera_from_world[0][3],
                            camera_from_world[1][3],
                            camera_from_world[2][3],
                            camera_from_world[3][3]);
  const std::string rigid = "a rigid transform (rotation and translation)";
  if (!is_finite) return rigid + " of finite numbers";
  if (last_row != glm::dvec4(0.0, 0.0, 0.0, 1.0)) {
    return rigid + " whose last row is 0, 0, 0, 1 and whose translation is the last column";
  }
  if (deviation > kRigidTolerance) {
    return fmt::format("{}, not one with axes of lengths {:.6g}, {:.6g} and {:.6g}{}",
                       rigid,
                       glm::length(rotation[0]),
                       glm::length(rotation[1]),
                       glm::length(rotation[2]),
                       AreUnit(rotation) ? " that are not at right angles" : "");
  }
  if (!(glm::determinant(rotation) > 0.0))
    return "a rotation, not a mirror image (an axis reversed, or two swapped)";
  return {};
}

}  // namespace pleinair
