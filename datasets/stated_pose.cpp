#include "datasets/stated_pose.h"

#include <cstddef>
#include <stdexcept>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "datasets/internal/held_camera.h"
#include "datasets/internal/sequence_json.h"

namespace pleinair {

glm::dmat4 ReadPoseFile(const std::filesystem::path& file) {
  const nlohmann::json document = LoadJson(file);
  const nlohmann::json* rows = &document;
  if (rows->is_object() && rows->contains("camera")) rows = &rows->at("camera");
  if (rows->is_object() && rows->contains("camera_from_world"))
    rows = &rows->at("camera_from_world");
  glm::dmat4 pose(1.0);
  const auto entries = JsonCursor(*rows, file.string()).List(4, 4);
  for (int r = 0; r < 4; ++r) {
    const auto row = entries[static_cast<std::size_t>(r)].List(4, 4);
    for (int c = 0; c < 4; ++c) pose[c][r] = row[static_cast<std::size_t>(c)].Number();
  }
  return pose;
}

glm::dmat4 PoseLookingAt(const glm::dvec3& camera_m,
                         const glm::dvec3& target_m,
                         const glm::dvec2& up) {
  const glm::dvec3 forward = target_m - camera_m;
  const glm::dvec3 right = glm::cross(forward, glm::dvec3(0.0, 0.0, 1.0));
  if (!(glm::length(right) > 1e-9 * glm::length(forward))) {
    throw std::invalid_argument(
        "camera: expected to look at a point that is not above, below or at "
        "its own place");
  }
  const glm::dvec3 z = glm::normalize(forward);
  const glm::dvec3 x = glm::normalize(right);
  const glm::dvec3 y = glm::cross(z, x);
  // Turns an upright camera's kUpright into `up`.
  const glm::dmat3 held_from_upright({-up.y, up.x, 0.0}, {-up.x, -up.y, 0.0}, {0.0, 0.0, 1.0});
  const glm::dmat3 camera_from_world = held_from_upright * glm::transpose(glm::dmat3(x, y, z));
  glm::dmat4 pose(camera_from_world);
  pose[3] = glm::dvec4(-(camera_from_world * camera_m), 1.0);
  return pose;
}

glm::dvec2 UpInPicture(const std::filesystem::path& photo) {
  return StoredUp(photo).value_or(kUpright);
}

}  // namespace pleinair
