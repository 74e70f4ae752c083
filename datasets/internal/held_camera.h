// How a picture's camera was held, against how its pose says.
#pragma once

#include <filesystem>
#include <optional>

#include <glm/vec2.hpp>

#include "scene/camera.h"

namespace pleinair {

// Upwards in the picture, in stored columns and rows, by its EXIF orientation. None where it states
// none, or that the picture is stored upright: cameras that do not know how they are held do so.
std::optional<glm::dvec2> StoredUp(const std::filesystem::path& picture);

// Pixels are used as they are stored: intrinsics and pose are of the sensor's rows and columns. So
// a picture shows another view where its EXIF orientation says that its camera was held otherwise
// than `camera` is posed: throws std::runtime_error, which does not name the file. Nothing is
// checked where the file states no orientation, or the camera looks up or down.
void RequireHeldAs(const Camera& camera, const std::filesystem::path& picture);

}  // namespace pleinair
