// A picture on a surface, filtered for near and far views. For files see mesh_io.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "scene/image.h"

namespace pleinair {

// Texture coordinates beyond a picture's edge.
enum class TextureWrap : std::uint8_t { kRepeat, kMirror, kClamp };

// The wrap mode along each axis.
struct TextureWraps {
  TextureWrap u = TextureWrap::kRepeat;
  TextureWrap v = TextureWrap::kRepeat;
  bool operator==(const TextureWraps&) const = default;
};

// Colours are sRGB codes (IEC 61966-2-1), alpha is linear; both are filtered in the linear scale.
//
// Levels   0 is the picture; each further one has sides half as long, rounded down, to 1x1. A texel
//          is the mean over exactly the area that it covers in the level before. So each level has
//          the picture's own mean, whatever the picture's size, until it is rounded to codes, by
//          half of one at most.
// Size     A picture of more than kMostTexels is halved as often as needed: the device keeps 8
//          bytes for each texel.
// Threads  safe from any once it is made.
class Texture {
 public:
  using Codes = Image<glm::u8vec4>;
  static constexpr std::size_t kMostTexels = std::size_t{1} << 24;

  // Throws std::invalid_argument for a picture without texels.
  explicit Texture(Codes picture);

  // Size of level 0.
  int Width() const { return levels_.front().width; }
  int Height() const { return levels_.front().height; }
  int LevelCount() const { return static_cast<int>(levels_.size()); }
  const Codes& Level(int level) const { return levels_[static_cast<std::size_t>(level)]; }
  // Number of halvings for kMostTexels.
  int TimesHalved() const { return times_halved_; }

  // Linear, of all texels: mean, and the largest and the least of each channel.
  const glm::vec3& Mean() const { return mean_; }
  const glm::vec4& Largest() const { return largest_; }
  const glm::vec4& Least() const { return least_; }

  // Linear value of a code of red, green or blue, in [0, 1].
  static const std::array<float, 256>& LinearOfCode();

  // The level whose texels are as wide as the longer of these two steps of uv, in [0, LevelCount()
  // - 1].
  float LevelFor(const glm::vec2& uv_across, const glm::vec2& uv_down) const;
  // Linear RGB and alpha: between the four nearest texels of a level, and between two levels. uv is
  // that of TriangleColours.
  glm::vec4 At(const glm::vec2& uv, float level, const TextureWraps& wraps) const;
  // Over a triangle, of all texels or of those that their alpha keeps. At most 256 texels are used,
  // of the level where the triangle has no more.
  enum class Of { kAll, kWhatIsThere };
  glm::vec3 MeanOver(const std::array<glm::vec2, 3>& corners_uv,
                     const TextureWraps& wraps,
                     Of of = Of::kAll) const;

 private:
  glm::vec4 TexelAt(const Codes& level, int x, int y) const;
  glm::vec4 Bilinear(const Codes& level, const glm::vec2& uv, const TextureWraps& wraps) const;

  std::vector<Codes> levels_;
  int times_halved_ = 0;
  glm::vec3 mean_{0.0f};
  glm::vec4 largest_{0.0f};
  glm::vec4 least_{1.0f};
};

}  // namespace pleinair
