// A reconstruction from photographs: cameras, their poses, and points. Plain data; for files see
// datasets/reconstruction/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "sunmodel/site.h"

namespace pleinair {

// A point in the model's frame.
struct ReconstructedPoint {
  std::int64_t id = 0;
  glm::dvec3 position{0.0};
  glm::dvec3 colour_srgb{0.5};  // In [0, 1], display values of the pictures.
};

// A point in one picture.
struct PointObservation {
  std::uint32_t point = 0;  // Into Reconstruction::points.
  glm::dvec2 pixel{0.0};    // In the picture as it was taken; integers are pixel centres.
};

// A photograph and its pose.
struct ReconstructedPicture {
  std::string name;                   // Path relative to the folder of the photographs.
  std::uint32_t camera = 0;           // Into Reconstruction::cameras.
  glm::dmat4 camera_from_model{1.0};  // Rigid; OpenCV's camera axes.
  std::vector<PointObservation> observations;

  glm::dvec3 Centre() const;
};

// A lens; several pictures may share it.
struct ReconstructedCamera {
  std::string name;
  CameraIntrinsics intrinsics;
};

// A model by structure from motion; unit and axes are the model's own unless stated.
struct Reconstruction {
  std::vector<ReconstructedCamera> cameras;
  std::vector<ReconstructedPicture> pictures;
  std::vector<ReconstructedPoint> points;
  // The model is east-north-up in metres about this place, as stated by its source.
  std::optional<Site> enu_at;
  std::vector<std::string> notes;  // Notes on what was left out.
};

// target = scale * rotation * source + translation.
struct Similarity {
  double scale = 1.0;
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
};

// Moves points and cameras; pixels do not change.
void Transform(const Similarity& target_from_model, Reconstruction& reconstruction);

// The points in a picture: its observations, or where the file has none, the points in front that
// project into it (some may be hidden).
std::vector<PointObservation> VisiblePoints(const Reconstruction& reconstruction,
                                            std::size_t picture);

}  // namespace pleinair
