#include "pipeline/effects/seen_shade.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vec2.hpp>

#include "pipeline/effects/real_pixels.h"
#include "scene/is_finite.h"

namespace pleinair {
namespace {

// Deviations of the albedo by which a surface in shade may be darker than predicted.
constexpr float kDarkerSigmas = 2.0f;
// Half the side of the averaging window, and the means between which the share rises from none of
// the sun to all of it. A straight edge takes three pixels; a stain or a manhole cover of less than
// a third of the window is no edge, nor is a third of pixels that noise puts on the wrong side.
constexpr int kWindowPx = 5;
constexpr float kAllHidden = 0.35f;
constexpr float kAllSeen = 0.65f;
// Fewer pixels, or a smaller share of those that say anything, are no shade: 12 are a tenth of the
// window's 121, of which the mean takes nothing, and in 1 % of pixels noise of 2.3 deviations makes
// the sunlit surface look shaded.
constexpr int kLeastPixels = 12;
constexpr double kLeastShare = 0.01;

// Whether a pixel that the mesh has in the sun is in the sun; none where that cannot be said.
std::optional<bool> IsInSun(const EffectFrame& frame, std::size_t pixel) {
  if (!IsFinite(frame.frame.radiance.pixels[pixel])) return std::nullopt;
  const RealPixel state = RealPixelOf(frame, pixel, LightOfPixel(frame, pixel));
  if (state.model_visibility < 0.5f) return std::nullopt;
  if (SunSeenWithout(frame, pixel, state) > 0.0f) return true;
  constexpr float kTiny = 1e-30f;
  const glm::vec3 log_ratio = glm::log(glm::max(state.observed, glm::vec3(kTiny)) /
                                       glm::max(state.shaded, glm::vec3(kTiny)));
  const float sigma = state.albedo_measured ? kLogSigmaMeasured : kLogSigmaGuessed;
  if (log_ratio.g < -kDarkerSigmas * sigma) return std::nullopt;
  return false;
}

// Sums over rectangles of a part of a picture.
class RectangleSums {
 public:
  RectangleSums(int width, int height) : sums_(width + 1, height + 1, glm::ivec2(0)) {}

  // To be called row by row, from the left.
  void Add(int x, int y, const glm::ivec2& value) {
    sums_.At(x + 1, y + 1) = value + sums_.At(x, y + 1) + sums_.At(x + 1, y) - sums_.At(x, y);
  }
  // Over (x, y) and what is up to `reach` pixels off.
  glm::ivec2 Around(int x, int y, int reach) const {
    const int left = std::max(x - reach, 0);
    const int top = std::max(y - reach, 0);
    const int right = std::min(x + reach + 1, sums_.width - 1);
    const int bottom = std::min(y + reach + 1, sums_.height - 1);
    return sums_.At(right, bottom) - sums_.At(left, bottom) - sums_.At(right, top) +
           sums_.At(left, top);
  }

 private:
  Image<glm::ivec2> sums_;
};

}  // namespace

SeenShade::SeenShade(ShadowPlaces places)
    : places_(std::move(places)),
      found_(places_.pixel.width, places_.pixel.height, Finding::kUnknown),
      left_(places_.pixel.width, places_.pixel.height, 1.0f) {
  for (int y = 0; y < places_.pixel.height; ++y) {
    for (int x = 0; x < places_.pixel.width; ++x) {
      if (places_.pixel.At(x, y) == ShadowPlaces::kNothing) continue;
      const glm::ivec2 at(x, y);
      PixelBox& box = boxes_.try_emplace(places_.object.At(x, y), PixelBox{at, at}).first->second;
      box.lower = glm::min(box.lower, at);
      box.upper = glm::max(box.upper, at);
    }
  }
}

void SeenShade::TakeMeans(std::uint32_t object, const PixelBox& box) {
  const glm::ivec2 size = box.upper - box.lower + 1;
  RectangleSums sums(size.x, size.y);  // Pixels that say anything, and those in the sun.
  const auto is_of_object = [&](int x, int y) {
    return places_.pixel.At(x, y) != ShadowPlaces::kNothing && places_.object.At(x, y) == object;
  };
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      const glm::ivec2 at = box.lower + glm::ivec2(x, y);
      const Finding finding = is_of_object(at.x, at.y) ? found_.At(at.x, at.y) : Finding::kUnknown;
      sums.Add(x, y, {finding != Finding::kUnknown ? 1 : 0, finding == Finding::kInSun ? 1 : 0});
    }
  }
  const int largest = std::max(size.x, size.y);
  const glm::ivec2 all = sums.Around(size.x / 2, size.y / 2, largest);
  const int in_shade = all.x - all.y;
  if (in_shade < kLeastPixels || in_shade < kLeastShare * all.x) return;
  tbb::parallel_for(0, size.y, [&](int y) {
    for (int x = 0; x < size.x; ++x) {
      const glm::ivec2 at = box.lower + glm::ivec2(x, y);
      if (!is_of_object(at.x, at.y)) continue;
      glm::ivec2 sum(0);
      for (int reach = kWindowPx; sum.x < kLeastPixels && reach < 2 * largest; reach *= 2) {
        sum = sums.Around(x, y, reach);
      }
      const float mean = static_cast<float>(sum.y) / static_cast<float>(sum.x);
      left_.At(at.x, at.y) = std::clamp((mean - kAllHidden) / (kAllSeen - kAllHidden), 0.0f, 1.0f);
    }
  });
}

const GrayImage* SeenShade::SunLeft(const EffectFrame& frame) {
  tbb::parallel_for(0, places_.pixel.height, [&](int y) {
    for (int x = 0; x < places_.pixel.width; ++x) {
      const std::int32_t pixel = places_.pixel.At(x, y);
      if (pixel < 0) continue;
      const std::optional<bool> is_in_sun = IsInSun(frame, static_cast<std::size_t>(pixel));
      Finding& finding = found_.At(x, y);
      finding = Finding::kUnknown;
      if (is_in_sun) finding = *is_in_sun ? Finding::kInSun : Finding::kInShade;
    }
  });
  if (std::find(found_.pixels.begin(), found_.pixels.end(), Finding::kInShade) ==
      found_.pixels.end()) {
    return nullptr;
  }
  std::fill(left_.pixels.begin(), left_.pixels.end(), 1.0f);
  for (const auto& [object, box] : boxes_) TakeMeans(object, box);
  return &left_;
}

void TakeSun(const ObjectSunShare& share, const GrayImage& left, ObjectSunShare& result) {
  constexpr int kSide = ObjectSunShare::kSamplesPerSide;
  result.x_px = share.x_px;
  result.y_px = share.y_px;
  if (result.seen.width != share.seen.width || result.seen.height != share.seen.height) {
    result.seen = GrayImage(share.seen.width, share.seen.height);
  }
  tbb::parallel_for(0, share.seen.height, [&](int y) {
    for (int x = 0; x < share.seen.width; ++x) {
      result.seen.At(x, y) = share.seen.At(x, y) * left.At(x / kSide, y / kSide);
    }
  });
}

}  // namespace pleinair
