// A camera's pose, adjusted together with the places of a mesh's edges.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "calib/internal/edge_view.h"
#include "calib/internal/reprojection.h"
#include "calib/mesh_edges.h"

namespace pleinair {

// Odds that a stated pose is off rather than exact, before the pictures are looked at. An
// assumption.
inline constexpr double kOddsBeforehand = 3.0;

// A place on an edge that the stated pose sees.
struct FixedPlace {
  std::size_t edge = 0;
  glm::dvec3 point_m{0.0};
  glm::dvec3 along_m{0.0};  // The edge's direction, unit.
};

// Where a pose puts a place; none outside of the picture.
std::optional<EdgePlace> PlaceAt(const EdgeView& view,
                                 const PictureSlopes& picture,
                                 const FixedPlace& place,
                                 const glm::dmat4& pose);

// A rotation vector and a translation that move `from` to `to`: MovedPose(from, result) is `to`.
Motion MotionBetween(const glm::dmat4& from, const glm::dmat4& to);

// The stated pose as a normal distribution.
struct PosePrior {
  glm::dmat4 pose{1.0};
  Motion sigmas = Motion::Zero();  // About and along the camera's axes.
};

// Places on the edges of a mesh, and pictures of one camera at one pose. Keeps references.
struct EdgePictures {
  const EdgeView& view;
  std::span<const MeshEdge> edges;
  std::span<const FixedPlace> places;
  std::span<const PictureSlopes* const> pictures;  // At least one.
  double steps_per_px = 0.0;       // Of all steps of light along the places' normals; above 0.
  std::optional<double> ground_m;  // Height of the ground; none: unknown.
};

struct EdgeAdjustment {
  glm::dmat4 camera_from_world{1.0};
  // Of the camera's motion.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double mesh_sigma_m = 0.0;  // The most likely one, of a corner along each axis.
  // Natural logarithm of the odds that the stated pose is off rather than exact.
  double log_odds = 0.0;
};

// The mean pose, given the stated one and the pictures' steps of light. Each corner of the mesh is
// displaced by a normal deviation of its own, and the edges that end there move with it. Corners on
// the ground are displaced along it only: heights are above it, and objects stand on it. A step of
// light near an edge is that edge, another edge of the mesh, or none, in each picture by itself.
// Where several steps may be the edge, it is known less well. Edges that do not agree with the
// others are taken to be elsewhere, each by one of a few deviations: the mesh lacks an eave.
//
// How far the mesh is off, and whether the stated pose is off as expected, by less, or not at all,
// follow from the pictures. The mean is over all of these, weighted by their evidence.
//
// `start`  is near the pose, to some pixels in the picture.
// Source   Generalised least squares (Aitken, Proc. R. Soc. Edinb. 55, 1936). Associations as in
//          the probabilistic data association filter (Bar-Shalom and Tse, Automatica 11, 1975).
// Cost     for 240 places some 0.3 s of one thread.
EdgeAdjustment AdjustPoseAndMesh(const EdgePictures& seen,
                                 const PosePrior& prior,
                                 const glm::dmat4& start);

}  // namespace pleinair
