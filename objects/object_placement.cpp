#include "objects/object_placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "objects/internal/convex_cast.h"
#include "objects/internal/support_tree.h"

namespace pleinair {
namespace {

// Gap between an object and what it touches: more than the rounding errors of meshes 1 km wide, a
// tenth of a visible gap.
constexpr double kClearanceM = 1e-4;

using Triangle = std::array<glm::dvec3, 3>;

// Between unit vectors; where they are opposite, about `about`.
glm::dmat3 SmallestRotation(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& about) {
  const glm::dvec3 axis = glm::cross(from, to);
  const double sine = glm::length(axis);
  const double angle = std::atan2(sine, glm::dot(from, to));
  // Below this there is nothing to turn, or no axis to turn about.
  if (!(sine > 1e-12)) {
    if (angle < 1.0) return glm::dmat3(1.0);
    const glm::dvec3 across = glm::normalize(about - glm::dot(about, from) * from);
    return glm::mat3_cast(glm::angleAxis(std::acos(-1.0), across));
  }
  return glm::mat3_cast(glm::angleAxis(angle, axis / sine));
}

void RequirePose(const glm::dmat4& pose) {
  const glm::dmat3 linear(pose);
  const double volume = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  if (std::isfinite(glm::dot(pose[3], pose[3])) && std::isfinite(volume) &&
      std::abs(glm::determinant(linear)) > 1e-9 * volume) {
    return;
  }
  throw std::invalid_argument("world_from_object: expected a finite, invertible transform");
}

glm::dmat4 About(const glm::dvec3& centre, const glm::dmat3& linear, const glm::dmat4& pose) {
  glm::dmat4 moved(linear * glm::dmat3(pose));
  moved[3] = glm::dvec4(centre + linear * (glm::dvec3(pose[3]) - centre), 1.0);
  return moved;
}

}  // namespace

PlaceableObject::PlaceableObject(const Mesh& mesh) {
  const BoundingBox box = BoundingBoxOf(mesh);
  std::vector<bool> is_used(mesh.positions_m.size(), false);
  std::vector<glm::dvec3> corners;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (is_used[triangle[i]]) continue;
      is_used[triangle[i]] = true;
      corners.emplace_back(mesh.positions_m[triangle[i]]);
    }
  }
  const glm::dvec3 centre = 0.5 * (glm::dvec3(box.lower_m) + glm::dvec3(box.upper_m));
  foot_ = {centre.x, centre.y, box.lower_m.z};
  height_ = static_cast<double>(box.upper_m.z) - box.lower_m.z;
  corners_ = std::make_shared<const SupportTree>(std::move(corners));
}

// One object that is being put onto one point, its axis already along the normal and its lowest
// corner on the point's plane. Places are offsets from there.
class Placing {
 public:
  Placing(const PlaceableObject& object,
          const glm::dmat3& linear,
          const SurfacePoint& point,
          const RayCaster& caster,
          const Mesh& mesh)
      : point_(point), caster_(caster), body_{*object.corners_, linear, {}} {
    const glm::dvec3& n = point.normal;
    body_.offset = point.position_m - linear * object.foot_;
    body_.offset += glm::dot(point.position_m - body_.Furthest(-n), n) * n;
    middle_ = linear * (object.foot_ + glm::dvec3(0.0, 0.0, 0.5 * object.height_)) + body_.offset;
    const glm::dvec3 across = glm::normalize(
        glm::cross(n, std::abs(n.x) < 0.5 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0)));
    axes_ = {across, glm::cross(n, across), n};
    for (int i = 0; i < 3; ++i) {
      upper_[i] = glm::dot(axes_[i], body_.Furthest(axes_[i]));
      lower_[i] = glm::dot(axes_[i], body_.Furthest(-axes_[i]));
    }
    size_m_ = glm::length(upper_ - lower_);
    for (const glm::uvec3& triangle : mesh.triangles) {
      const Triangle corners{glm::dvec3(mesh.positions_m[triangle.x]),
                             glm::dvec3(mesh.positions_m[triangle.y]),
                             glm::dvec3(mesh.positions_m[triangle.z])};
      if (IsNear(corners, glm::dvec3(0.0), size_m_, size_m_)) near_.push_back(corners);
    }
  }

  const glm::dvec3& Offset() const { return body_.offset; }

  // The offset at which it rests, with the ways to there; none where there is no room.
  std::optional<RestingObject> Rest() const {
    const auto raised = RestAt(glm::dvec3(0.0));
    if (raised && raised->raised_m <= 2.0 * kClearanceM) return raised;
    const auto slid = Slid();
    if (!raised || !slid) return raised ? raised : slid;
    const double slid_m = glm::length(slid->slid_m) + std::abs(slid->raised_m);
    return raised->raised_m <= slid_m ? raised : slid;
  }

 private:
  // Whether a triangle may be met by the object at `offset`, moved by so much at most along the
  // surface and along the normal. False for what is not finite.
  bool IsNear(const Triangle& corners,
              const glm::dvec3& offset,
              double along_surface_m,
              double along_normal_m) const {
    for (int i = 0; i < 3; ++i) {
      const double at = glm::dot(offset, axes_[i]);
      const double a = glm::dot(axes_[i], corners[0]) - at;
      const double b = glm::dot(axes_[i], corners[1]) - at;
      const double c = glm::dot(axes_[i], corners[2]) - at;
      const double reach = i < 2 ? along_surface_m : along_normal_m;
      if (!std::isfinite(a + b + c) || std::min({a, b, c}) > upper_[i] + reach ||
          std::max({a, b, c}) < lower_[i] - reach) {
        return false;
      }
    }
    return true;
  }

  ConvexBody At(const glm::dvec3& offset) const {
    return {body_.points, body_.linear, body_.offset + offset};
  }

  // Whether the middle of the object at `offset` is in sight of the point.
  bool IsInSight(const glm::dvec3& offset) const {
    const glm::dvec3 from = point_.position_m + kClearanceM * point_.normal;
    const glm::dvec3 way = middle_ + offset - from;
    const double length = glm::length(way);
    return !(length > 0.0) ||
           !caster_.Occluded(
               glm::vec3(from), glm::normalize(glm::vec3(way)), static_cast<float>(length));
  }

  // Heights over `offset`, relative to it, at which the object meets something; in ascending order.
  std::vector<Interval> MeetingHeights(const glm::dvec3& offset) const {
    std::vector<Interval> heights;
    const ConvexBody body = At(offset);
    for (const Triangle& triangle : near_) {
      if (!IsNear(triangle, offset, 0.0, size_m_)) continue;
      if (const auto met = MeetingOf(body, triangle, point_.normal, size_m_)) {
        heights.push_back(*met);
      }
    }
    std::sort(heights.begin(), heights.end(), [](const Interval& a, const Interval& b) {
      return a.from < b.from;
    });
    return heights;
  }

  // The height over `offset` of the first contact: above what the object meets there, or, where it
  // meets nothing, lowered onto what is below.
  std::optional<double> ContactHeight(const glm::dvec3& offset) const {
    constexpr double kNothing = -std::numeric_limits<double>::infinity();
    double height = kNothing;
    for (const Interval& met : MeetingHeights(offset)) {
      // This and all that follow stand over the object.
      if (met.from > std::max(height, kClearanceM)) break;
      height = std::max(height, met.to + kClearanceM);
    }
    if (height == kNothing || !(height < size_m_)) return std::nullopt;
    return height;
  }

  std::optional<RestingObject> RestAt(const glm::dvec3& offset) const {
    const auto height = ContactHeight(offset);
    if (!height) return std::nullopt;
    const glm::dvec3 place = offset + *height * point_.normal;
    if (!IsInSight(place)) return std::nullopt;
    RestingObject resting;
    resting.slid_m = offset;
    resting.raised_m = *height;
    return resting;
  }

  // Moved along the surface, from one obstacle after the other, the nearest way first.
  std::optional<RestingObject> Slid() const {
    const glm::dvec3 clearance = kClearanceM * point_.normal;
    constexpr int kMostObstacles = 12;  // The walls of a niche, each in a few triangles.
    glm::dvec3 offset(0.0);
    for (int i = 0; i < kMostObstacles; ++i) {
      std::optional<glm::dvec3> shortest;
      bool is_free = true;
      for (const Triangle& triangle : near_) {
        if (!IsNear(triangle, offset + clearance, 0.0, 0.0) ||
            !Meet(At(offset + clearance), triangle)) {
          continue;
        }
        is_free = false;
        const auto way = WayOut(triangle, offset + clearance);
        if (way && (!shortest || glm::length(*way) < glm::length(*shortest))) shortest = way;
      }
      if (is_free) return RestAt(offset);
      if (!shortest) return std::nullopt;
      offset += *shortest;
      if (!(glm::length(offset) < size_m_)) return std::nullopt;
    }
    return std::nullopt;
  }

  // The way along the surface and square to the triangle on which the object at `offset` leaves it.
  std::optional<glm::dvec3> WayOut(const Triangle& triangle, const glm::dvec3& offset) const {
    const glm::dvec3& n = point_.normal;
    const glm::dvec3 facing = glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    glm::dvec3 away = facing - glm::dot(facing, n) * n;
    const double length = glm::length(away);
    // A surface within half a degree of the one underneath is not beside the object.
    if (!(length > 0.01 * glm::length(facing))) return std::nullopt;
    away /= length;
    // The side of the point; of a point on the triangle's plane, that of the winding.
    const double side = glm::dot(point_.position_m - triangle[0], facing) / glm::length(facing);
    if (side < -kClearanceM) away = -away;
    const auto met = MeetingOf(At(offset), triangle, away, size_m_);
    if (!met || !(met->to < size_m_)) return std::nullopt;
    return (std::max(met->to, 0.0) + kClearanceM) * away;
  }

  const SurfacePoint& point_;
  const RayCaster& caster_;
  ConvexBody body_;
  glm::dvec3 middle_{0.0};
  std::array<glm::dvec3, 3> axes_;  // Along the surface, and the normal.
  glm::dvec3 lower_{0.0};           // The body's bounds along them.
  glm::dvec3 upper_{0.0};
  double size_m_ = 0.0;
  std::vector<Triangle> near_;
};

std::optional<RestingObject> RestOn(const PlaceableObject& object,
                                    const glm::dmat4& world_from_object,
                                    const SurfacePoint& point,
                                    const RayCaster& caster,
                                    const Mesh& mesh) {
  RequirePose(world_from_object);
  const glm::dmat3 before(world_from_object);
  const glm::dmat3 linear =
      SmallestRotation(glm::normalize(before[2]), point.normal, before[0]) * before;
  const Placing placing(object, linear, point, caster, mesh);
  auto resting = placing.Rest();
  if (!resting) return std::nullopt;
  resting->world_from_object = glm::dmat4(linear);
  resting->world_from_object[3] =
      glm::dvec4(placing.Offset() + resting->slid_m + resting->raised_m * point.normal, 1.0);
  return resting;
}

glm::dvec3 AxisOf(const glm::dmat4& world_from_object) {
  return glm::normalize(glm::dvec3(world_from_object[2]));
}

glm::dvec3 FootOf(const PlaceableObject& object, const glm::dmat4& world_from_object) {
  return glm::dvec3(world_from_object * glm::dvec4(object.FootObject(), 1.0));
}

glm::dmat4 Turned(const PlaceableObject& object,
                  const glm::dmat4& world_from_object,
                  double angle_rad) {
  RequirePose(world_from_object);
  return About(FootOf(object, world_from_object),
               glm::mat3_cast(glm::angleAxis(angle_rad, AxisOf(world_from_object))),
               world_from_object);
}

glm::dmat4 Lifted(const glm::dmat4& world_from_object, double height_m) {
  glm::dmat4 lifted = world_from_object;
  lifted[3] += glm::dvec4(height_m * AxisOf(world_from_object), 0.0);
  return lifted;
}

glm::dmat4 Scaled(const PlaceableObject& object,
                  const glm::dmat4& world_from_object,
                  double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw std::invalid_argument("factor: expected a positive number, found " +
                                std::to_string(factor));
  }
  return About(FootOf(object, world_from_object), glm::dmat3(factor), world_from_object);
}

}  // namespace pleinair
