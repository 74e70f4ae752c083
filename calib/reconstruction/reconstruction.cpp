#include "calib/reconstruction/reconstruction.h"

#include <glm/matrix.hpp>

#include "calib/internal/camera_centre.h"
#include "calib/lens.h"

namespace pleinair {

glm::dvec3 ReconstructedPicture::Centre() const { return CentreOfCamera(camera_from_model); }

void Transform(const Similarity& move, Reconstruction& reconstruction) {
  for (ReconstructedPoint& point : reconstruction.points) {
    point.position = move.scale * (move.rotation * point.position) + move.translation;
  }
  for (ReconstructedPicture& picture : reconstruction.pictures) {
    const glm::dmat3 rotation =
        glm::dmat3(picture.camera_from_model) * glm::transpose(move.rotation);
    const glm::dvec3 translation =
        move.scale * glm::dvec3(picture.camera_from_model[3]) - rotation * move.translation;
    picture.camera_from_model = glm::dmat4(rotation);
    picture.camera_from_model[3] = glm::dvec4(translation, 1.0);
  }
}

std::vector<PointObservation> VisiblePoints(const Reconstruction& reconstruction,
                                            std::size_t index) {
  const ReconstructedPicture& picture = reconstruction.pictures[index];
  if (!picture.observations.empty()) return picture.observations;
  const CameraIntrinsics& intrinsics = reconstruction.cameras[picture.camera].intrinsics;
  const Lens lens(intrinsics);
  std::vector<PointObservation> visible;
  for (std::size_t i = 0; i < reconstruction.points.size(); ++i) {
    const auto pixel = lens.ProjectToPixel(
        glm::dvec3(picture.camera_from_model * glm::dvec4(reconstruction.points[i].position, 1.0)));
    if (!pixel || !(pixel->x >= -0.5 && pixel->x < intrinsics.width_px - 0.5) ||
        !(pixel->y >= -0.5 && pixel->y < intrinsics.height_px - 0.5)) {
      continue;
    }
    visible.push_back({static_cast<std::uint32_t>(i), *pixel});
  }
  return visible;
}

}  // namespace pleinair
