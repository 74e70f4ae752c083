// A camera's pose as a person states it: in a file, or by where it stands and what it looks at.
#pragma once

#include <filesystem>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// `camera_from_world` of a JSON file: its own, its camera's, or the file's only content. Throws
// std::runtime_error naming the file.
glm::dmat4 ReadPoseFile(const std::filesystem::path& file);

// Where up is in a picture's pixels, along +x right and +y down: of a camera that is held upright.
inline constexpr glm::dvec2 kUpright{0.0, -1.0};
// The same of a photograph, by its EXIF orientation; upright where it states none.
glm::dvec2 UpInPicture(const std::filesystem::path& photo);

// Level, with `up` along an axis of the picture. Throws std::invalid_argument where the two places
// are above each other.
glm::dmat4 PoseLookingAt(const glm::dvec3& camera_m,
                         const glm::dvec3& target_m,
                         const glm::dvec2& up = kUpright);

}  // namespace pleinair
