// How a picture's camera was held, against how its pose says.
#pragma once

#include <filesystem>

#include "scene/camera.h"

namespace pleinair {

// Pixels are used as they are stored: intrinsics and pose are of the sensor's rows and columns. So
// a picture shows another view where its EXIF orientation says that its camera was held otherwise
// than `camera` is posed: throws std::runtime_error, which does not name the file. Nothing is
// checked where the file states no orientation, or the camera looks up or down.
void RequireHeldAs(const Camera& camera, const std::filesystem::path& picture);

}  // namespace pleinair
