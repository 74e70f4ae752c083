#include "pipeline/internal/effects/seen_shade.h"

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

#include "pipeline/internal/effects/real_pixels.h"
#include "scene/mean_beside.h"

namespace pleinair {
namespace {

// Half the side of the windows: that in which most of a picture's pixels decide, so often, and that
// of the mean on the object. The means between which the share rises from none of the sun to all of
// it. A straight edge takes three pixels; a stain or a cover of less than half the window is no
// edge, nor is a third of pixels that noise puts on the wrong side. What the first majority leaves
// of a cover's bright rim, the second takes away.
constexpr int kWindowPx = 5;
constexpr int kMajorities = 2;
constexpr float kAllHidden = 0.35f;
constexpr float kAllSeen = 0.65f;
// Fewer pixels say nothing: a tenth of the window's 121, of which the mean takes nothing. Nor do
// fewer places in shade, or a smaller share of an object's.
constexpr int kLeastPixels = 12;
constexpr double kLeastShare = 0.01;

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

// Of pixels that say anything, and those in the sun.
template <class FindingAt>
RectangleSums SumsOf(const glm::ivec2& size, const FindingAt& finding_at) {
  RectangleSums sums(size.x, size.y);
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      const SeenShade::Finding finding = finding_at(x, y);
      sums.Add(x,
               y,
               {finding != SeenShade::Finding::kUnknown ? 1 : 0,
                finding == SeenShade::Finding::kInSun ? 1 : 0});
    }
  }
  return sums;
}

// What most of the pixels around each one say; unknown where few say anything.
void TakeMajority(Image<SeenShade::Finding>& found) {
  using Finding = SeenShade::Finding;
  const RectangleSums sums =
      SumsOf({found.width, found.height}, [&](int x, int y) { return found.At(x, y); });
  tbb::parallel_for(0, found.height, [&](int y) {
    for (int x = 0; x < found.width; ++x) {
      const glm::ivec2 around = sums.Around(x, y, kWindowPx);
      Finding& finding = found.At(x, y);
      if (around.x < kLeastPixels) {
        finding = Finding::kUnknown;
      } else {
        finding = 2 * around.y >= around.x ? Finding::kInSun : Finding::kInShade;
      }
    }
  });
}

}  // namespace

SeenShade::SeenShade(ShadowPlaces places, const glm::ivec2& picture_px)
    : places_(std::move(places)),
      picture_width_px_(picture_px.x),
      found_(places_.pixel.width, places_.pixel.height, Finding::kUnknown),
      left_(places_.pixel.width, places_.pixel.height, 1.0f) {
  const auto grow = [](PixelBox& box, const glm::ivec2& at) {
    box.lower = glm::min(box.lower, at);
    box.upper = glm::max(box.upper, at);
  };
  std::optional<PixelBox> shadows;
  for (int y = 0; y < places_.pixel.height; ++y) {
    for (int x = 0; x < places_.pixel.width; ++x) {
      const std::int32_t pixel = places_.pixel.At(x, y);
      if (pixel == ShadowPlaces::kNothing) continue;
      const glm::ivec2 at(x, y);
      grow(boxes_.try_emplace(places_.object.At(x, y), PixelBox{at, at}).first->second, at);
      if (pixel < 0) continue;
      if (!shadows) shadows = PixelBox{InPicture(pixel), InPicture(pixel)};
      grow(*shadows, InPicture(pixel));
    }
  }
  if (!shadows) return;
  static_assert(kReachPx == kMajorities * kWindowPx);
  shadows_ = {glm::max(shadows->lower - kReachPx, 0),
              glm::min(shadows->upper + kReachPx, picture_px - 1)};
  const glm::ivec2 size = shadows_.Size();
  RectangleSums shadow_count(size.x, size.y);
  Image<std::uint8_t> is_shadow(size.x, size.y, 0);
  for (const std::int32_t pixel : places_.pixel.pixels) {
    if (pixel < 0) continue;
    const glm::ivec2 at = InPicture(pixel) - shadows_.lower;
    is_shadow.At(at.x, at.y) = 1;
  }
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) shadow_count.Add(x, y, glm::ivec2(is_shadow.At(x, y)));
  }
  is_around_shadow_ = Image<std::uint8_t>(size.x, size.y, 0);
  found_in_picture_ = Image<Finding>(size.x, size.y, Finding::kUnknown);
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      is_around_shadow_.At(x, y) = shadow_count.Around(x, y, kReachPx).x > 0 ? 1 : 0;
    }
  }
}

glm::ivec2 SeenShade::InPicture(std::int32_t pixel) const {
  return {pixel % picture_width_px_, pixel / picture_width_px_};
}

void SeenShade::FindPixels(const EffectFrame& frame) {
  tbb::parallel_for(0, found_in_picture_.height, [&](int y) {
    for (int x = 0; x < found_in_picture_.width; ++x) {
      if (is_around_shadow_.At(x, y) == 0) continue;
      const glm::ivec2 at = shadows_.lower + glm::ivec2(x, y);
      const std::optional<bool> is_in_sun =
          LooksSunlit(frame, static_cast<std::size_t>(at.y * picture_width_px_ + at.x));
      Finding& finding = found_in_picture_.At(x, y);
      finding = Finding::kUnknown;
      if (is_in_sun) finding = *is_in_sun ? Finding::kInSun : Finding::kInShade;
    }
  });
}

void SeenShade::TakeMeans(std::uint32_t object, const PixelBox& box) {
  const glm::ivec2 size = box.Size();
  const auto is_of_object = [&](int x, int y) {
    return places_.pixel.At(x, y) != ShadowPlaces::kNothing && places_.object.At(x, y) == object;
  };
  const RectangleSums sums = SumsOf(size, [&](int x, int y) {
    const glm::ivec2 at = box.lower + glm::ivec2(x, y);
    return is_of_object(at.x, at.y) ? found_.At(at.x, at.y) : Finding::kUnknown;
  });
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

void SeenShade::FillBeside(const PixelBox& box) {
  const glm::ivec2 lower = glm::max(box.lower - 1, 0);
  const glm::ivec2 upper =
      glm::min(box.upper + 1, glm::ivec2(places_.pixel.width, places_.pixel.height) - 1);
  tbb::parallel_for(lower.y, upper.y + 1, [&](int y) {
    for (int x = lower.x; x <= upper.x; ++x) {
      if (places_.pixel.At(x, y) != ShadowPlaces::kNothing) continue;
      const auto mean = MeanBeside(left_, x, y, [&](int u, int v) {
        return places_.pixel.At(u, v) != ShadowPlaces::kNothing;
      });
      if (mean) left_.At(x, y) = *mean;
    }
  });
}

const GrayImage* SeenShade::SunLeft(const EffectFrame& frame) {
  FindPixels(frame);
  if (std::find(found_in_picture_.pixels.begin(),
                found_in_picture_.pixels.end(),
                Finding::kInShade) == found_in_picture_.pixels.end()) {
    return nullptr;
  }
  for (int k = 0; k < kMajorities; ++k) TakeMajority(found_in_picture_);
  for (std::size_t i = 0; i < found_.pixels.size(); ++i) {
    const std::int32_t pixel = places_.pixel.pixels[i];
    if (pixel < 0) continue;
    const glm::ivec2 at = InPicture(pixel) - shadows_.lower;
    found_.pixels[i] = found_in_picture_.At(at.x, at.y);
  }
  std::fill(left_.pixels.begin(), left_.pixels.end(), 1.0f);
  for (const auto& [object, box] : boxes_) TakeMeans(object, box);
  for (const auto& [object, box] : boxes_) FillBeside(box);
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
