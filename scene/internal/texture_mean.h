// A texture as one colour: materials here are uniform.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

namespace pleinair {

// Mean linear RGB of a PNG or JPEG image in memory whose code values are sRGB; nothing when it
// cannot be decoded.
std::optional<glm::vec3> MeanLinearColour(std::span<const std::byte> encoded);

}  // namespace pleinair
