#include "render/internal/texture_store.h"

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>

namespace pleinair {
namespace {

using HalfTexel = std::array<std::uint16_t, 4>;

std::vector<HalfTexel> HalvesOf(const Texture::Codes& codes) {
  std::array<std::uint16_t, 256> of_colour{};
  std::array<std::uint16_t, 256> of_alpha{};
  for (std::size_t code = 0; code < 256; ++code) {
    of_colour[code] = glm::packHalf1x16(Texture::LinearOfCode()[code]);
    of_alpha[code] = glm::packHalf1x16(static_cast<float>(code) / 255.0f);
  }
  std::vector<HalfTexel> halves;
  halves.reserve(codes.pixels.size());
  for (const glm::u8vec4& code : codes.pixels) {
    halves.push_back({of_colour[code.r], of_colour[code.g], of_colour[code.b], of_alpha[code.a]});
  }
  return halves;
}

GLint GlWrapOf(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::kMirror:
      return GL_MIRRORED_REPEAT;
    case TextureWrap::kClamp:
      return GL_CLAMP_TO_EDGE;
    case TextureWrap::kRepeat:
      break;
  }
  return GL_REPEAT;
}

// Returns the last level.
int UploadLevels(const Texture& texture) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  int first = 0;
  while (texture.Level(first).width > most || texture.Level(first).height > most) ++first;
  const int count = texture.LevelCount() - first;
  // Not this one's; a lost context has one for ever.
  constexpr int kMostErrors = 16;
  for (int i = 0; i < kMostErrors && glGetError() != GL_NO_ERROR; ++i) continue;
  const Texture::Codes& finest = texture.Level(first);
  glTexStorage2D(GL_TEXTURE_2D, count, GL_RGBA16F, finest.width, finest.height);
  if (glGetError() == GL_OUT_OF_MEMORY) {
    throw std::runtime_error(std::string("texture of an object: this device has no room for ") +
                             std::to_string(finest.width) + "x" + std::to_string(finest.height) +
                             " texels: expected a smaller picture");
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int level = 0; level < count; ++level) {
    const Texture::Codes& codes = texture.Level(first + level);
    glTexSubImage2D(GL_TEXTURE_2D,
                    level,
                    0,
                    0,
                    codes.width,
                    codes.height,
                    GL_RGBA,
                    GL_HALF_FLOAT,
                    HalvesOf(codes).data());
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return count - 1;
}

}  // namespace

void TextureStore::Keep(std::span<const std::shared_ptr<const Texture>> wanted) {
  std::map<const Texture*, Uploaded> kept;
  for (const std::shared_ptr<const Texture>& texture : wanted) {
    const auto found = uploaded_.find(texture.get());
    if (found != uploaded_.end()) kept.insert(uploaded_.extract(found));
    kept[texture.get()].texture = texture;
  }
  uploaded_ = std::move(kept);
}

int TextureStore::Bind(const Texture& texture, const TextureWraps& wraps) {
  Uploaded& uploaded = uploaded_.at(&texture);
  if (!uploaded.object) {
    GlObject object = MakeTexture();
    glBindTexture(GL_TEXTURE_2D, object.Name());
    uploaded.last_level = UploadLevels(texture);
    uploaded.object = std::move(object);
  }
  glBindTexture(GL_TEXTURE_2D, uploaded.object.Name());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GlWrapOf(wraps.u));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GlWrapOf(wraps.v));
  return uploaded.last_level;
}

}  // namespace pleinair
