// Which way is up in a reconstruction.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "calib/reconstruction/reconstruction.h"
#include "scene/image.h"

namespace pleinair {

// A direction that is horizontal, as far as one knows: up is perpendicular to it. A known up is two
// of these.
struct LevelDirection {
  glm::dvec3 direction{1.0, 0.0, 0.0};  // Unit.
  double sigma_rad = 0.1;
  double weight = 1.0;  // Below 1 for one of many that share their errors.
};

struct UpEstimate {
  glm::dvec3 up{0.0, 0.0, 1.0};
  double sigma_rad = 0.0;  // The worse axis.
};

// How cameras are held: level from left to right within some degrees, and looking towards the
// horizon, roughly. `orientations` are EXIF's, a picture each, or empty.
std::vector<LevelDirection> LevelOfCameras(const Reconstruction& reconstruction,
                                           std::span<const int> orientations);
// Opposite to what is down in the pictures: says which of two directions up is.
glm::dvec3 UpInPictures(const Reconstruction& reconstruction, std::span<const int> orientations);

// What is perpendicular to `up`.
std::vector<LevelDirection> LevelBelow(const glm::dvec3& up, double sigma_rad);

// Normals of walls, and directions in the ground: from the biggest planes of the points that stand
// or lie within some degrees of where `up` would have them.
std::vector<LevelDirection> LevelOfPlanes(const Reconstruction& reconstruction,
                                          const glm::dvec3& up,
                                          double tolerance);

// Normals of the planes through a camera and the upright edges in its picture, which are those
// within 8 degrees of where `up` would have them. Together they count as half a degree.
std::vector<LevelDirection> LevelOfVerticalEdges(const Gray8Image& picture,
                                                 const CameraIntrinsics& intrinsics,
                                                 const glm::dmat4& camera_from_model,
                                                 const glm::dvec3& up);

// The direction that fits these best, outliers down-weighted (Cauchy), of the two with `sense` on
// its side. A direction that nothing states has a large deviation.
// Throws   std::invalid_argument where there is no evidence.
UpEstimate EstimateUp(std::span<const LevelDirection> evidence, const glm::dvec3& sense);

}  // namespace pleinair
