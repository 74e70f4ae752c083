// Hypotheses for a camera's pose from matches some of which are wrong, and how well they fit.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/camera_pose.h"

namespace pleinair {

inline constexpr std::size_t kFewestMatches = 4;

struct ScoredPose {
  glm::dmat4 pose{1.0};
  double cost = std::numeric_limits<double>::infinity();
  std::size_t inliers = 0;
};

// The two poses in which points, moved onto the plane that is nearest to them, are seen along
// `rays`, one each, at distance 1. Fewer where they are on a line, or no pose fits.
std::vector<glm::dmat4> FlatPoses(const std::vector<glm::dvec3>& points_m,
                                  const std::vector<glm::dvec2>& rays);

// One picture's matches. Keeps references to all that it is given.
class PoseSearch {
 public:
  PoseSearch(const Lens& lens,
             std::span<const PointMatch> matches,
             const CameraPoseOptions& options);

  // None where the lens does not see the point.
  std::optional<glm::dvec2> Project(const glm::dmat4& pose, const PointMatch& match) const;
  double ResidualPx(const glm::dmat4& pose, const PointMatch& match) const;

  // Squared residuals, those of wrong matches cut off.
  ScoredPose Score(const glm::dmat4& pose) const;
  std::vector<PointMatch> InliersOf(const glm::dmat4& pose) const;

  // Up to four poses that three matches allow, appended.
  void AddFromTriple(const std::array<std::size_t, 3>& triple,
                     std::vector<glm::dmat4>& poses) const;

  // Poses from triples of matches, and those of a flat board, best first. All triples are used;
  // where there are too many, as many as contain almost certainly one without a wrong match.
  std::vector<ScoredPose> Hypotheses() const;

  // The two poses of these matches with their points moved onto the plane that is nearest to them.
  std::vector<glm::dmat4> FlatPosesOf(std::span<const PointMatch> matches) const;

  const CameraIntrinsics& Intrinsics() const { return lens_.Intrinsics(); }

 private:
  const Lens& lens_;
  std::span<const PointMatch> matches_;
  const CameraPoseOptions& options_;
  std::vector<PointMatch> visible_;  // Those whose pixel the lens can see.
  std::vector<glm::dvec2> rays_;     // Their rays at distance 1, undistorted.
};

}  // namespace pleinair
