#include "scene/texture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/srgb.h"

namespace pleinair {
namespace {

constexpr float kAlphaOfCode = 1.0f / 255.0f;

glm::vec4 LinearOf(const glm::u8vec4& code) {
  const std::array<float, 256>& linear = Texture::LinearOfCode();
  return {linear[code.r], linear[code.g], linear[code.b], kAlphaOfCode * code.a};
}

// The code that is nearest in the scale of codes.
std::uint8_t CodeOfLinear(float value) {
  static const std::array<float, 255> kUpperEnds = [] {
    std::array<float, 255> ends{};
    for (std::size_t code = 0; code < ends.size(); ++code) {
      ends[code] = static_cast<float>(LinearFromSrgb((static_cast<double>(code) + 0.5) / 255.0));
    }
    return ends;
  }();
  return static_cast<std::uint8_t>(std::upper_bound(kUpperEnds.begin(), kUpperEnds.end(), value) -
                                   kUpperEnds.begin());
}

// Weights of the texels that a texel of a halved side covers: two texels; for an odd side three,
// with parts of the outer ones. A side of 1 stays.
struct Covered {
  int first = 0;
  int count = 0;
  std::array<float, 3> share{};
};

std::vector<Covered> HalvesOf(int side) {
  const int half = std::max(side / 2, 1);
  std::vector<Covered> halves(static_cast<std::size_t>(half));
  const double width = static_cast<double>(side) / half;
  for (int i = 0; i < half; ++i) {
    Covered& covered = halves[static_cast<std::size_t>(i)];
    const double begin = i * width;
    const double end = std::min((i + 1) * width, static_cast<double>(side));
    covered.first = static_cast<int>(begin);
    for (int texel = covered.first; texel < side && covered.count < 3; ++texel) {
      const double inside =
          std::min(end, texel + 1.0) - std::max(begin, static_cast<double>(texel));
      if (!(inside > 0.0)) break;
      covered.share[static_cast<std::size_t>(covered.count++)] = static_cast<float>(inside / width);
    }
  }
  return halves;
}

// `linear_at` of the side before.
template <typename LinearAt>
Image<glm::vec4> Halved(int width, int height, const LinearAt& linear_at) {
  const std::vector<Covered> columns = HalvesOf(width);
  const std::vector<Covered> rows = HalvesOf(height);
  Image<glm::vec4> half(static_cast<int>(columns.size()), static_cast<int>(rows.size()));
  for (int y = 0; y < half.height; ++y) {
    const Covered& of_y = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < half.width; ++x) {
      const Covered& of_x = columns[static_cast<std::size_t>(x)];
      glm::vec4 sum(0.0f);
      for (int v = 0; v < of_y.count; ++v) {
        for (int u = 0; u < of_x.count; ++u) {
          sum += of_y.share[static_cast<std::size_t>(v)] * of_x.share[static_cast<std::size_t>(u)] *
                 linear_at(of_x.first + u, of_y.first + v);
        }
      }
      half.At(x, y) = sum;
    }
  }
  return half;
}

Texture::Codes CodesOf(const Image<glm::vec4>& linear) {
  Texture::Codes codes(linear.width, linear.height);
  for (std::size_t i = 0; i < linear.pixels.size(); ++i) {
    const glm::vec4& value = linear.pixels[i];
    codes.pixels[i] = {CodeOfLinear(value.r),
                       CodeOfLinear(value.g),
                       CodeOfLinear(value.b),
                       static_cast<std::uint8_t>(std::lround(255.0f * value.a))};
  }
  return codes;
}

// A texel's place in a picture of that side.
int Wrapped(int texel, int side, TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::kClamp:
      return std::clamp(texel, 0, side - 1);
    case TextureWrap::kMirror: {
      const int turned = ((texel % (2 * side)) + 2 * side) % (2 * side);
      return turned < side ? turned : 2 * side - 1 - turned;
    }
    case TextureWrap::kRepeat:
      break;
  }
  return ((texel % side) + side) % side;
}

// The two texels around a place and what the upper one counts for. Whole turns are taken off first,
// in float, so that any finite number has a place.
struct Around {
  int lower = 0;
  int upper = 0;
  float share = 0.0f;
};

Around AroundPlace(float u, int side, TextureWrap wrap) {
  const float turn = wrap == TextureWrap::kMirror ? 2.0f : 1.0f;
  const float near =
      wrap == TextureWrap::kClamp ? glm::clamp(u, -1.0f, 2.0f) : u - turn * std::floor(u / turn);
  const float place = near * static_cast<float>(side) - 0.5f;
  const float below = std::floor(place);
  const int texel = static_cast<int>(below);
  return {Wrapped(texel, side, wrap), Wrapped(texel + 1, side, wrap), place - below};
}

}  // namespace

const std::array<float, 256>& Texture::LinearOfCode() {
  static const std::array<float, 256> kLinear = [] {
    std::array<float, 256> linear{};
    for (std::size_t code = 0; code < linear.size(); ++code) {
      linear[code] = static_cast<float>(LinearFromSrgb(static_cast<double>(code) / 255.0));
    }
    return linear;
  }();
  return kLinear;
}

Texture::Texture(Codes picture) {
  if (picture.Empty()) throw std::invalid_argument("texture: the picture has no texels");
  glm::dvec3 sum(0.0);
  largest_ = glm::vec4(0.0f);
  for (const glm::u8vec4& code : picture.pixels) {
    const glm::vec4 linear = LinearOf(code);
    sum += glm::dvec3(linear);
    largest_ = glm::max(largest_, linear);
    least_ = glm::min(least_, linear);
  }
  mean_ = glm::vec3(sum / static_cast<double>(picture.pixels.size()));
  Image<glm::vec4> linear;
  int width = picture.width;
  int height = picture.height;
  if (picture.pixels.size() <= kMostTexels) {
    levels_.push_back(std::move(picture));
  } else {
    ++times_halved_;
    linear = Halved(width, height, [&](int x, int y) { return LinearOf(picture.At(x, y)); });
    picture = Codes();
    while (linear.pixels.size() > kMostTexels) {
      ++times_halved_;
      linear = Halved(linear.width, linear.height, [&](int x, int y) { return linear.At(x, y); });
    }
    levels_.push_back(CodesOf(linear));
    width = linear.width;
    height = linear.height;
  }
  while (width > 1 || height > 1) {
    linear = linear.Empty()
                 ? Halved(width, height, [&](int x, int y) { return LinearOf(Level(0).At(x, y)); })
                 : Halved(width, height, [&](int x, int y) { return linear.At(x, y); });
    width = linear.width;
    height = linear.height;
    levels_.push_back(CodesOf(linear));
  }
}

float Texture::LevelFor(const glm::vec2& uv_across, const glm::vec2& uv_down) const {
  const glm::vec2 size(Width(), Height());
  const glm::vec2 across = uv_across * size;
  const glm::vec2 down = uv_down * size;
  const float length2 = std::max(glm::dot(across, across), glm::dot(down, down));
  // Beyond it all levels end; NaN as well.
  constexpr float kFar = 1e30f;
  if (!(length2 < kFar)) return static_cast<float>(LevelCount() - 1);
  return glm::clamp(
      0.5f * std::log2(std::max(length2, 1.0f / kFar)), 0.0f, static_cast<float>(LevelCount() - 1));
}

glm::vec4 Texture::TexelAt(const Codes& level, int x, int y) const {
  return LinearOf(level.At(x, y));
}

glm::vec4 Texture::Bilinear(const Codes& level,
                            const glm::vec2& uv,
                            const TextureWraps& wraps) const {
  const Around x = AroundPlace(uv.x, level.width, wraps.u);
  const Around y = AroundPlace(uv.y, level.height, wraps.v);
  return (1.0f - y.share) * ((1.0f - x.share) * TexelAt(level, x.lower, y.lower) +
                             x.share * TexelAt(level, x.upper, y.lower)) +
         y.share * ((1.0f - x.share) * TexelAt(level, x.lower, y.upper) +
                    x.share * TexelAt(level, x.upper, y.upper));
}

glm::vec4 Texture::At(const glm::vec2& uv, float level, const TextureWraps& wraps) const {
  const float below = std::floor(level);
  const int lower = static_cast<int>(below);
  const float share = level - below;
  const glm::vec4 fine = Bilinear(Level(lower), uv, wraps);
  if (!(share > 0.0f)) return fine;
  return (1.0f - share) * fine + share * Bilinear(Level(lower + 1), uv, wraps);
}

glm::vec3 Texture::MeanOver(const std::array<glm::vec2, 3>& corners_uv,
                            const TextureWraps& wraps,
                            Of of) const {
  const glm::dvec2 origin(corners_uv[0]);
  const glm::dvec2 a = glm::dvec2(corners_uv[1]) - origin;
  const glm::dvec2 b = glm::dvec2(corners_uv[2]) - origin;
  double texels = 0.5 * std::abs(a.x * b.y - a.y * b.x) * Width() * Height();
  if (!std::isfinite(texels)) return mean_;
  constexpr double kMostLookedAt = 256.0;
  int level = 0;
  while (texels > kMostLookedAt && level + 1 < LevelCount()) {
    ++level;
    texels /= 4.0;
  }
  // The middles of side^2 equal triangles.
  constexpr int kMostPerSide = 16;
  const int side =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(std::min(texels, 1e6)))), 1, kMostPerSide);
  glm::dvec3 sum(0.0);
  glm::dvec3 sum_there(0.0);
  double alpha = 0.0;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; i + j < side; ++j) {
      const auto at = [&](double third) {
        const glm::vec2 uv(origin + (i + third) / side * a + (j + third) / side * b);
        const glm::dvec4 texel(Bilinear(Level(level), uv, wraps));
        sum += glm::dvec3(texel);
        sum_there += texel.a * glm::dvec3(texel);
        alpha += texel.a;
      };
      at(1.0 / 3.0);
      if (i + j + 1 < side) at(2.0 / 3.0);
    }
  }
  if (of == Of::kWhatIsThere && alpha > 0.0) return glm::vec3(sum_there / alpha);
  return glm::vec3(sum / static_cast<double>(side * side));
}

}  // namespace pleinair
