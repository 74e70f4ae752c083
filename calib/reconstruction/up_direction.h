// Finds the up direction of a reconstruction.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "calib/reconstruction/reconstruction.h"
#include "scene/image.h"

namespace pleinair {

// A direction that is probably horizontal: up is perpendicular to it. A known up gives two of
// these.
struct LevelDirection {
  glm::dvec3 direction{1.0, 0.0, 0.0};  // Unit.
  double sigma_rad = 0.1;
  double weight = 1.0;  // Below 1 for directions that share their errors.
};

// The estimated direction, unit, in the model's frame.
struct UpEstimate {
  glm::dvec3 up{0.0, 0.0, 1.0};
  double sigma_rad = 0.0;  // The worse axis.
};

// Evidence from level cameras: they are level from left to right within some degrees, and look
// roughly towards the horizon. `orientations` are EXIF's, one for each picture, or empty.
std::vector<LevelDirection> LevelOfCameras(const Reconstruction& reconstruction,
                                           std::span<const int> orientations);
// Means of the up and right directions of the pictures; not unit.
glm::dvec3 UpInPictures(const Reconstruction& reconstruction, std::span<const int> orientations);
glm::dvec3 RightInPictures(const Reconstruction& reconstruction, std::span<const int> orientations);

// Evidence from a known `up`: two directions perpendicular to it.
std::vector<LevelDirection> LevelBelow(const glm::dvec3& up, double sigma_rad);

// One of the largest planes of the points.
struct PlaneNormal {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double share = 0.0;  // Share of the points.
  double sigma_rad = 0.0;
};

// Those with at least 4 % of the points, of any kind.
std::vector<PlaneNormal> FindPlaneNormals(const Reconstruction& reconstruction, double tolerance);

// Normals of walls, and directions in the ground, for planes that are upright or level within 4
// degrees for `up`.
std::vector<LevelDirection> LevelOfPlanes(std::span<const PlaneNormal> planes,
                                          const glm::dvec3& up);

// A straight edge in a picture. The edge in the world lies in a plane with the camera.
struct PictureEdge {
  glm::dvec3 normal{1.0, 0.0, 0.0};  // Normal of that plane, unit, in the model's frame.
  double length = 0.0;               // Length over the picture's height.
};

// Straight edges from 4 % of the picture's height.
//
// Source   OpenCV's line segment detector: von Gioi et al., TPAMI 32(4), 2010.
std::vector<PictureEdge> FindEdges(const Gray8Image& picture,
                                   const CameraIntrinsics& intrinsics,
                                   const glm::dmat4& camera_from_model);

// Returns the direction near `up` that most edges run along, and for which most planes are walls or
// ground. Cameras may be tilted by up to 45 degrees from `up` and turned about their axes by up to
// 12. `right` is the mean right direction of the pictures. None where at most a tenth of edges and
// planes agree.
std::optional<glm::dvec3> SearchUp(std::span<const PictureEdge> edges,
                                   std::span<const PlaneNormal> planes,
                                   const glm::dvec3& up,
                                   const glm::dvec3& right);

// Evidence that up lies in the planes of the edges that are upright within 2 degrees. Together they
// count as half a degree for each picture, as a rolling shutter's shear is common to all edges of
// one picture.
std::vector<LevelDirection> LevelOfEdges(std::span<const PictureEdge> edges,
                                         const glm::dvec3& up,
                                         std::size_t pictures);

// Returns the level direction along and across which most of the other edges run, as those of a
// building; none where there is none.
std::optional<glm::dvec3> LevelEdgeDirection(std::span<const PictureEdge> edges,
                                             const glm::dvec3& up);

// Returns the direction that fits the evidence best, robustly (Cauchy), with the sign of `sense`.
// An undetermined direction has a large deviation.
// Throws   std::invalid_argument where there is no evidence.
UpEstimate EstimateUp(std::span<const LevelDirection> evidence, const glm::dvec3& sense);

}  // namespace pleinair
