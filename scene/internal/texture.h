// A material's picture, decoded: read for its means, over all of it and over a face.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// What a texture's code values stand for.
enum class TextureScale { kSrgb, kLinear };

class Texture {
 public:
  // Of a PNG or JPEG image in memory; nothing when it cannot be decoded.
  static std::optional<Texture> Decode(std::span<const std::byte> encoded,
                                       TextureScale scale = TextureScale::kSrgb);

  int Width() const { return codes_.width; }
  int Height() const { return codes_.height; }
  // In the linear scale.
  const glm::vec3& Mean() const { return mean_; }
  // Over a triangle, of u to the right and v up, that repeats beyond [0, 1]. At most 256 texels of
  // it are looked at, spread evenly. Coordinates that are not finite give the mean of all.
  glm::vec3 MeanOver(const std::array<glm::dvec2, 3>& corners_uv) const;

 private:
  glm::vec3 TexelAt(const glm::dvec2& uv) const;

  Rgb8Image codes_;
  std::array<float, 256> linear_of_code_{};
  glm::vec3 mean_{0.0f};
};

}  // namespace pleinair
