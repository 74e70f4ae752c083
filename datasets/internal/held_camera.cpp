#include "datasets/internal/held_camera.h"

#include <optional>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "calib/exif_place.h"

namespace pleinair {

std::optional<glm::dvec2> StoredUp(const std::filesystem::path& picture) {
  switch (ReadExifPlace(picture).orientation.value_or(1)) {
    case 3:
    case 4:
      return glm::dvec2(0.0, 1.0);
    case 5:
    case 6:
      return glm::dvec2(-1.0, 0.0);
    case 7:
    case 8:
      return glm::dvec2(1.0, 0.0);
    default:
      return std::nullopt;
  }
}

void RequireHeldAs(const Camera& camera, const std::filesystem::path& picture) {
  const std::optional<glm::dvec2> stored_up = StoredUp(picture);
  if (!stored_up) return;
  const glm::dvec3 up = glm::dmat3(camera.camera_from_world) * glm::dvec3(0.0, 0.0, 1.0);
  const glm::dvec2 in_picture(up);
  constexpr double kLeastLength = 0.3;  // Else it looks up or down, where no side is up.
  constexpr double kLeastCosine = 0.5;
  const double length = glm::length(in_picture);
  if (length < kLeastLength) return;
  if (glm::dot(in_picture, *stored_up) >= kLeastCosine * length) return;
  throw std::runtime_error("expected a camera held as the pose says, found EXIF orientation " +
                           std::to_string(ReadExifPlace(picture).orientation.value_or(1)) +
                           ": a pose for a camera held so would fit (`pleinair site new` with "
                           "--camera PHOTO, --camera-at and --camera-to makes one); remove the tag "
                           "where the pixels are turned already");
}

}  // namespace pleinair
