#include "datasets/picture_frame.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace pleinair {
namespace {

bool IsUsable(const glm::vec3& radiance) {
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(radiance[c]) || radiance[c] < 0.0f) return false;
  }
  return true;
}

// What Frame::unusable has of a code of one channel.
using FlagsOfCode = std::array<std::uint8_t, 256>;
FlagsOfCode FlagsOfChannel(int channel) {
  FlagsOfCode flags{};
  for (std::size_t code = 0; code < flags.size(); ++code) {
    if (code <= kNoiseFloorUpToCode) flags[code] = kNearBlack;
    if (code >= kClippedFromCode) flags[code] = kClipped[channel];
  }
  return flags;
}

}  // namespace

void SetRadiance(RgbImage radiance, Frame& frame) {
  frame.defects = DefectsOf(radiance);
  frame.radiance = std::move(radiance);
  frame.clipped = Gray8Image(frame.radiance.width, frame.radiance.height);
  frame.unusable = frame.clipped;
  for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
    frame.unusable.pixels[i] = IsUsable(frame.radiance.pixels[i]) ? 0 : kUnusable;
  }
}

bool HasFinitePixel(const RgbImage& radiance, const ImageDefects& defects) {
  return defects.not_finite < static_cast<std::int64_t>(radiance.pixels.size());
}

void SetCodes(Rgb8Image codes,
              const ResponseCurve& response,
              std::shared_ptr<const SignalNoise> noise,
              Frame& frame) {
  frame.noise = std::move(noise);
  frame.radiance = RadianceFromCodes(codes, response, frame.exposure.value_or(1.0));
  frame.clipped = Gray8Image(codes.width, codes.height);
  frame.unusable = frame.clipped;
  static const std::array<FlagsOfCode, 3> flags = {
      FlagsOfChannel(0), FlagsOfChannel(1), FlagsOfChannel(2)};
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    const glm::u8vec3& code = codes.pixels[i];
    const int unusable = flags[0][code.x] | flags[1][code.y] | flags[2][code.z];
    frame.clipped.pixels[i] = (unusable & ~kNearBlack) != 0 ? 1 : 0;
    frame.unusable.pixels[i] = static_cast<std::uint8_t>(unusable);
  }
  frame.codes = std::move(codes);
}

void SetDeveloped(DevelopedPicture picture, Frame& frame) {
  const auto scale = static_cast<float>(1.0 / frame.exposure.value_or(1.0));
  for (glm::vec3& pixel : picture.signal_rgb.pixels) pixel *= scale;
  SetRadiance(std::move(picture.signal_rgb), frame);
  frame.clipped = std::move(picture.clipped);
  for (std::size_t i = 0; i < frame.clipped.pixels.size(); ++i) {
    if (frame.clipped.pixels[i] == 0) continue;
    frame.unusable.pixels[i] |= kClipped[0] | kClipped[1] | kClipped[2];
  }
}

}  // namespace pleinair
