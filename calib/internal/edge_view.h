// The edges of a mesh in a camera's picture: where a pose puts them, and where the picture has
// steps of light next to them.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <ceres/tiny_solver_autodiff_function.h>
#include <Eigen/Core>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <opencv2/core.hpp>

#include "calib/camera_pose.h"
#include "calib/internal/reprojection.h"
#include "calib/lens.h"
#include "calib/mesh_edges.h"
#include "scene/image.h"
#include "scene/ray_caster.h"

namespace pleinair {

inline constexpr double kEdgePlaceStepPx = 8.0;
inline constexpr std::size_t kMostEdgePlaces = 800;
// With fewer, a view says nothing of the camera's pose.
inline constexpr std::size_t kFewestEdgePlaces = 40;
// A picture's edge so near is the mesh's.
inline constexpr double kNearPx = 2.0;
// Share of the places that must have an edge so near, beyond the share that has one by chance: the
// picture of leaves has edges everywhere.
inline constexpr double kLeastShareOverChance = 0.2;

// Throws std::invalid_argument unless the picture has the lens's size.
void RequireLensSize(const CameraIntrinsics& lens, const Rgb8Image& picture);

// Steepness of a smoothed picture's light, at each place and for any direction: the structure
// tensor, summed over the channels.
class PictureSlopes {
 public:
  PictureSlopes(const Rgb8Image& picture, double sigma_px);

  bool Holds(const glm::dvec2& at, double margin_px) const;
  // Codes a pixel along a unit direction, the root of the sum over channels squared.
  double Slope(const glm::dvec2& at, const glm::dvec2& direction) const;

 private:
  cv::Mat tensor_;  // (dx dx, dx dy, dy dy).
};

// A place on an edge that the camera sees, and where the picture has edges along its normal.
struct EdgePlace {
  std::size_t edge = 0;
  glm::dvec3 point_m{0.0};
  glm::dvec2 pixel{0.0};
  glm::dvec2 normal{0.0};
  std::vector<double> steps_px;  // Offsets along the normal.

  double NearestPx() const;  // Infinite where there is none.
};

// Offsets of the picture's steps of light along a place's normal.
std::vector<double> StepsAlong(const PictureSlopes& slopes,
                               const EdgePlace& place,
                               double reach_px);

// The mesh as one camera sees it. Keeps references to all that it is given.
class EdgeView {
 public:
  EdgeView(const Lens& lens, const EdgeModel& model)
      : lens_(lens), edges_(model.edges), rays_(model.rays) {}

  // Places on the edges in view, kEdgePlaceStepPx apart or so that there are no more than `most`.
  std::vector<EdgePlace> PlacesOf(const glm::dmat4& pose,
                                  const PictureSlopes& slopes,
                                  std::size_t most = kMostEdgePlaces) const;
  // None where the point is not before the camera.
  std::optional<glm::dvec2> Project(const glm::dmat4& pose, const glm::dvec3& point) const;
  const CameraIntrinsics& Intrinsics() const { return lens_.Intrinsics(); }

 private:
  void AddPlaces(std::size_t index,
                 const glm::dmat4& pose,
                 const glm::dvec3& eye,
                 const PictureSlopes& slopes,
                 std::vector<EdgePlace>& places) const;

  const Lens& lens_;
  std::span<const MeshEdge> edges_;
  const RayCaster& rays_;
};

// By how far the edges in the picture of the one pose are elsewhere in that of the other: the
// median place.
double ShiftPx(const EdgeView& view,
               const PictureSlopes& slopes,
               const glm::dmat4& from,
               const glm::dmat4& to);

// A sample with the step of light that it is to lie on.
struct EdgeMatch {
  std::size_t edge = 0;
  PointMatch match;
  glm::dvec2 normal{0.0};
  double root_weight = 1.0;
};

// Errors across the edges, of a camera that moves from `pose`.
struct NormalErrors {
  int NumResiduals() const { return static_cast<int>(matches.size()); }

  template <typename T>
  [[gnu::flatten]] bool operator()(const T* motion, T* errors) const {
    for (const EdgeMatch& match : matches) {
      const glm::dvec4 point = pose * glm::dvec4(match.match.point_world_m, 1.0);
      const auto moved = MovedPoint<T>(motion, {T(point.x), T(point.y), T(point.z)});
      std::array<T, 2> error;
      if (!PixelError(intrinsics, moved, match.match.pixel, error.data())) return false;
      *errors++ = match.root_weight * (match.normal.x * error[0] + match.normal.y * error[1]);
    }
    return true;
  }

  const CameraIntrinsics& intrinsics;
  std::span<const EdgeMatch> matches;
  glm::dmat4 pose;
};
using NormalErrorsAndJacobian = ceres::TinySolverAutoDiffFunction<NormalErrors, Eigen::Dynamic, 6>;

// The errors where the camera stays, and their derivatives by its motion.
struct LinearErrors {
  Eigen::VectorXd residuals;
  Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian;
};
LinearErrors Linearised(const NormalErrors& errors);

// Each place with its nearest step of light; those without one are left out. The influence of steps
// decreases with their distance, in units of `scale_px`.
std::vector<EdgeMatch> MatchesOf(const std::vector<EdgePlace>& places, double scale_px);

// The group of a match.
struct EdgeGroup {
  std::size_t number = 0;  // From 0.
  // Direction of the match's normal in terms of the group's: 1 or -1. A normal follows the order of
  // its edge's ends, so parallel edges of one group may have opposite ones.
  double sign = 1.0;
};

// Groups matches whose edges are displaced together: those of one edge of the mesh, and those of
// parallel edges next to each other in the picture, which match the same step of light.
std::vector<EdgeGroup> GroupsOf(const std::vector<EdgeMatch>& matches);

}  // namespace pleinair
