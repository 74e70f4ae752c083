// Which way is up in a reconstruction.
#pragma once

#include <optional>
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
// Means of what is up and to the right in the pictures; not unit.
glm::dvec3 UpInPictures(const Reconstruction& reconstruction, std::span<const int> orientations);
glm::dvec3 RightInPictures(const Reconstruction& reconstruction, std::span<const int> orientations);

// What is perpendicular to `up`.
std::vector<LevelDirection> LevelBelow(const glm::dvec3& up, double sigma_rad);

// One of the biggest planes of the points.
struct PlaneNormal {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double share = 0.0;  // Of the points.
  double sigma_rad = 0.0;
};

// Those of 4 % of the points at least, whatever they are.
std::vector<PlaneNormal> FindPlaneNormals(const Reconstruction& reconstruction, double tolerance);

// Normals of walls, and directions in the ground: of planes that stand or lie within 4 degrees of
// where `up` would have them.
std::vector<LevelDirection> LevelOfPlanes(std::span<const PlaneNormal> planes,
                                          const glm::dvec3& up);

// A straight edge in a picture. What it is in the world lies in a plane with the camera.
struct PictureEdge {
  glm::dvec3 normal{1.0, 0.0, 0.0};  // Of that plane, unit, in the model's frame.
  double length = 0.0;               // Of the picture's height.
};

// Straight edges from 4 % of the picture's height.
//
// Source   OpenCV's line segment detector: von Gioi et al., TPAMI 32(4), 2010.
std::vector<PictureEdge> FindEdges(const Gray8Image& picture,
                                   const CameraIntrinsics& intrinsics,
                                   const glm::dmat4& camera_from_model);

// The direction near `up` that most edges run along and with which most planes are walls or ground,
// cameras being tilted by up to 45 degrees from `up` and turned about their axes by up to 12;
// `right` is to the right in the pictures, in the mean. None where a tenth of these are so at most.
std::optional<glm::dvec3> SearchUp(std::span<const PictureEdge> edges,
                                   std::span<const PlaneNormal> planes,
                                   const glm::dvec3& up,
                                   const glm::dvec3& right);

// That up lies in the planes of the edges that are upright within 2 degrees. Together they count as
// half a degree for each picture, as a rolling shutter's shear is the same for all of one.
std::vector<LevelDirection> LevelOfEdges(std::span<const PictureEdge> edges,
                                         const glm::dvec3& up,
                                         std::size_t pictures);

// The level direction along which, and at a right angle to which, most of the other edges run, as
// those of a building; none where there is none.
std::optional<glm::dvec3> LevelEdgeDirection(std::span<const PictureEdge> edges,
                                             const glm::dvec3& up);

// The direction that fits these best, outliers down-weighted (Cauchy), of the two with `sense` on
// its side. A direction that nothing states has a large deviation.
// Throws   std::invalid_argument where there is no evidence.
UpEstimate EstimateUp(std::span<const LevelDirection> evidence, const glm::dvec3& sense);

}  // namespace pleinair
