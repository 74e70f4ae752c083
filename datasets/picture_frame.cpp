#include "datasets/picture_frame.h"

#include <algorithm>
#include <cmath>
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
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    const glm::u8vec3& code = codes.pixels[i];
    const int brightest = std::max({code.x, code.y, code.z});
    const int darkest = std::min({code.x, code.y, code.z});
    frame.clipped.pixels[i] = brightest >= kClippedFromCode ? 1 : 0;
    int unusable = darkest <= kNoiseFloorUpToCode ? kNearBlack : 0;
    for (int c = 0; c < 3; ++c) unusable |= code[c] >= kClippedFromCode ? kClipped[c] : 0;
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
