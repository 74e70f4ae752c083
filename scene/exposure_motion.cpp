#include "scene/exposure_motion.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace pleinair {
namespace {

// The rotation nearest to `matrix`, whose determinant is above 0: Newton's iteration for the polar
// decomposition (Higham, SIAM J. Sci. Stat. Comput. 7(4), 1986), which squares the error each time.
glm::dmat3 NearestRotation(const glm::dmat3& matrix) {
  glm::dmat3 rotation = matrix;
  for (int i = 0; i < 32; ++i) {
    const glm::dmat3 next = 0.5 * (rotation + glm::transpose(glm::inverse(rotation)));
    double change = 0.0;
    for (int c = 0; c < 3; ++c) change = std::max(change, glm::length(next[c] - rotation[c]));
    rotation = next;
    if (!(change > 1e-15)) break;
  }
  return rotation;
}

glm::dvec3 TurnOf(const glm::dmat3& rotation) {
  glm::dquat q = glm::normalize(glm::quat_cast(rotation));
  if (q.w < 0.0) q = -q;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);  // Sine of half the angle.
  if (!(sine > 0.0)) return glm::dvec3(0.0);
  return (2.0 * std::atan2(sine, q.w) / sine) * axis;
}

}  // namespace

bool SteadyMotion::Moves() const {
  return velocity_m_s != glm::dvec3(0.0) || turn_rad_s != glm::dvec3(0.0) ||
         stretch_per_s != glm::dmat3(0.0);
}

glm::dmat4 SteadyMotion::After(double seconds) const {
  glm::dmat4 turned(1.0);
  const double angle = glm::length(turn_rad_s) * seconds;
  if (angle != 0.0) turned = glm::rotate(turned, angle, glm::normalize(turn_rad_s));
  const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), centre_m + seconds * velocity_m_s) *
                           turned * glm::dmat4(glm::dmat3(1.0) + seconds * stretch_per_s);
  return glm::translate(moved, -centre_m);
}

std::optional<SteadyMotion> MotionOf(const glm::dmat4& now_from_before,
                                     double seconds,
                                     const glm::dvec3& centre_now_m) {
  SteadyMotion motion;
  motion.centre_m = centre_now_m;
  if (now_from_before == glm::dmat4(1.0)) return motion;
  const glm::dmat3 linear(now_from_before);
  // A thing that shrinks to a millionth has gone.
  if (!(glm::determinant(linear) > 1e-18)) return std::nullopt;
  const glm::dmat3 rotation = NearestRotation(linear);
  const glm::dvec3 before(glm::inverse(now_from_before) * glm::dvec4(centre_now_m, 1.0));
  motion.velocity_m_s = (centre_now_m - before) / seconds;
  motion.turn_rad_s = TurnOf(rotation) / seconds;
  motion.stretch_per_s = (glm::transpose(rotation) * linear - glm::dmat3(1.0)) / seconds;
  // Rounding alone stretches nothing.
  constexpr double kRounding = 1e-12;
  double stretch = 0.0;
  for (int c = 0; c < 3; ++c) stretch += glm::length(motion.stretch_per_s[c]) * seconds;
  if (stretch < kRounding) motion.stretch_per_s = glm::dmat3(0.0);
  return motion;
}

bool ExposureMotion::Moves() const {
  if (!(exposure_s > 0.0) && !(readout_s > 0.0)) return false;
  return camera.Moves() ||
         std::any_of(objects.begin(), objects.end(), [](const auto& one) { return one.Moves(); });
}

}  // namespace pleinair
