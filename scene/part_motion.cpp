#include "scene/part_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace pleinair {
namespace {

// Between which keys a time lies, and where: 0 at the first, 1 at the second.
struct Span {
  std::size_t first = 0;
  std::size_t second = 0;
  double share = 0.0;
  double length_s = 0.0;
};

Span SpanAt(const std::vector<double>& times_s, double time_s) {
  const auto after = std::upper_bound(times_s.begin(), times_s.end(), time_s);
  if (after == times_s.begin()) return {};
  const auto second = static_cast<std::size_t>(after - times_s.begin());
  if (second == times_s.size()) return {second - 1, second - 1};
  const double length_s = times_s[second] - times_s[second - 1];
  return {second - 1, second, (time_s - times_s[second - 1]) / length_s, length_s};
}

// glTF 2.0, appendix C.4.
glm::dvec4 Spline(const std::vector<glm::dvec4>& values, const Span& span) {
  const double t = span.share;
  const double t2 = t * t;
  const double t3 = t2 * t;
  const glm::dvec4& from = values[3 * span.first + 1];
  const glm::dvec4& leaving = values[3 * span.first + 2];
  const glm::dvec4& arriving = values[3 * span.second];
  const glm::dvec4& to = values[3 * span.second + 1];
  return (2.0 * t3 - 3.0 * t2 + 1.0) * from + span.length_s * (t3 - 2.0 * t2 + t) * leaving +
         (3.0 * t2 - 2.0 * t3) * to + span.length_s * (t3 - t2) * arriving;
}

glm::dquat QuaternionOf(const glm::dvec4& xyzw) {
  return glm::normalize(glm::dquat(xyzw.w, xyzw.x, xyzw.y, xyzw.z));
}

}  // namespace

glm::dvec4 KeyTrack::At(double time_s) const {
  const Span span = SpanAt(times_s, time_s);
  if (interpolation == Interpolation::kCubicSpline) return Spline(values, span);
  if (interpolation == Interpolation::kStep) return values[span.first];
  return glm::mix(values[span.first], values[span.second], span.share);
}

glm::dquat KeyTrack::RotationAt(double time_s) const {
  if (interpolation != Interpolation::kLinear) return QuaternionOf(At(time_s));
  const Span span = SpanAt(times_s, time_s);
  return glm::normalize(
      glm::slerp(QuaternionOf(values[span.first]), QuaternionOf(values[span.second]), span.share));
}

glm::dmat4 MovingNode::ParentFromNodeAt(double time_s) const {
  if (!Moves()) return rest;
  const glm::dvec3 moved =
      translation_track ? glm::dvec3(translation_track->At(time_s)) : translation;
  const glm::dquat turned = rotation_track ? rotation_track->RotationAt(time_s) : rotation;
  const glm::dvec3 scaled = scale_track ? glm::dvec3(scale_track->At(time_s)) : scale;
  return glm::translate(glm::dmat4(1.0), moved) * glm::mat4_cast(turned) *
         glm::scale(glm::dmat4(1.0), scaled);
}

PartMotion::PartMotion(std::vector<MovingNode> chain, double duration_s)
    : chain_(std::move(chain)), duration_s_(duration_s) {
  if (!(duration_s > 0.0) || !std::isfinite(duration_s)) {
    throw std::invalid_argument("animation: duration " + std::to_string(duration_s) +
                                " s: expected a positive number");
  }
}

glm::dmat4 PartMotion::FileFromPart(double time_s) const {
  glm::dmat4 file_from_part(1.0);
  if (chain_.empty()) return file_from_part;
  const double looped_s = time_s - duration_s_ * std::floor(time_s / duration_s_);
  for (const MovingNode& node : chain_) file_from_part *= node.ParentFromNodeAt(looped_s);
  return file_from_part;
}

glm::dmat4 PartMotion::FileFromStart(double time_s) const {
  const glm::dmat4 start = FileFromPart(0.0);
  const glm::dmat4 now = FileFromPart(time_s);
  if (now == start) return glm::dmat4(1.0);
  const double determinant = glm::determinant(glm::dmat3(start));
  if (determinant == 0.0 || !std::isfinite(determinant)) {
    throw std::runtime_error(
        "animation: a node has no extent at its beginning: expected a scale "
        "other than 0");
  }
  glm::dmat4 file_from_start = now * glm::inverse(start);
  // Exactly affine: the product's last row has rounding errors.
  for (int column = 0; column < 4; ++column) file_from_start[column].w = column == 3 ? 1.0 : 0.0;
  return file_from_start;
}

}  // namespace pleinair
