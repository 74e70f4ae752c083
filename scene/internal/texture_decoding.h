// Textures from the bytes of image files.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>

#include "scene/texture.h"

namespace pleinair {

// The texture of a PNG or JPEG image in memory; null when DecodePicture refuses it. Alpha is 1
// unless `with_alpha`.
std::shared_ptr<const Texture> DecodeTexture(std::span<const std::byte> encoded, bool with_alpha);

// The mean of such an image whose codes are linear values.
std::optional<glm::vec3> MeanOfLinearImage(std::span<const std::byte> encoded);

// Those of one file that are decoded, by name, alpha included or not: several materials may want
// the same one.
using TexturesByName = std::map<std::pair<std::string, bool>, std::shared_ptr<const Texture>>;

}  // namespace pleinair
