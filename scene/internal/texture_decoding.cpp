#include "scene/internal/texture_decoding.h"

#include <exception>
#include <utility>

#include "scene/internal/picture_codes.h"

namespace pleinair {
namespace {

std::optional<Texture::Codes> DecodedTexels(std::span<const std::byte> encoded) {
  try {
    if (encoded.empty()) return std::nullopt;
    return DecodePicture("texture", encoded);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::shared_ptr<const Texture> DecodeTexture(std::span<const std::byte> encoded, bool with_alpha) {
  std::optional<Texture::Codes> codes = DecodedTexels(encoded);
  if (!codes) return nullptr;
  if (!with_alpha) {
    for (glm::u8vec4& texel : codes->pixels) texel.a = 255;
  }
  return std::make_shared<const Texture>(std::move(*codes));
}

std::optional<glm::vec3> MeanOfLinearImage(std::span<const std::byte> encoded) {
  const std::optional<Texture::Codes> codes = DecodedTexels(encoded);
  if (!codes) return std::nullopt;
  glm::dvec3 sum(0.0);
  for (const glm::u8vec4& texel : codes->pixels) sum += glm::dvec3(texel);
  return glm::vec3(sum / (255.0 * static_cast<double>(codes->pixels.size())));
}

}  // namespace pleinair
