#include "relight/survey/internal/unmodelled_shade.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

// All constants are in logarithms. Hue is red over blue. Assumed of one paving: its level varies by
// a tenth from pixel to pixel, and each channel by 5 % about that. A step between two pixels then
// varies by 0.14 in level, 0.1 in hue and 0.09 in green.

// Twice what a paving's steps of hue vary by.
constexpr float kLeastHueStep = 0.18f;
// Three times what a paving's steps of level vary by.
constexpr float kLeastLevelStep = 0.4f;
// How far a step's level may be below the expected one: light from surroundings that the mesh lacks
// brightens the shade by up to 40 %. And how far above it: what hides the sun may hide 45 % of the
// sky.
constexpr float kLevelBelow = 0.35f;
constexpr float kLevelAbove = 0.6f;
// Shares of the expected step of hue. Such light is nearer to the sun's colour, which makes it
// smaller; shade under the blue part of the sky has a larger one.
constexpr float kLeastHueShare = 0.6f;
constexpr float kMostHueShare = 1.5f;
// What a paving's steps vary by; of green, which has no such range, 1.7 times that.
constexpr float kHueSlack = 0.1f;
constexpr float kGreenSlack = 0.15f;
// Twice what a paving's steps of level vary by: smaller ones are no border of a part.
constexpr float kVisibleStep = 0.25f;
// A shade's steps in the median, in which texture and noise cancel. Those of two real shadows are
// off by 0.02 in green, and have 1.04 of the expected hue. Edges of materials that pass the limits
// of single steps are off by up to 0.1, and mostly have 0.6 to 0.85.
constexpr double kMedianGreenSlack = 0.06;
constexpr double kLeastMedianHueShare = 0.85;
constexpr double kMostMedianHueShare = 1.3;
// How much one shade's pixels vary, from the last one beside an edge on: a third darker or half
// brighter, as the sky's visible share varies below what hides the sun. The least step of level is
// less than that, so the hue must hold, too: half-way to the sun's ends the shade.
constexpr float kSameLevel = 0.45f;
constexpr float kSameHueShare = 0.5f;

// A square as wide as the distance at which pixels are compared, in a map of 1024.
constexpr std::size_t kFewestPixels = 64;
// Three pixels of border in each of a square's four directions, twice: fewer are chance.
constexpr std::size_t kFewestSteps = 24;
// Two real shadows have 0.33 and 0.34, as they end at walls and glass as well; other dark parts in
// six panoramas have up to 0.25.
constexpr double kLeastShareOfBorder = 0.3;
// 18 degrees: more than the normals of a rough ground differ by, less than those of walls or roofs
// that meet.
constexpr float kOnePlaneCosine = 0.95f;

float LevelOf(const glm::vec3& log_rgb) { return (log_rgb.x + log_rgb.y + log_rgb.z) / 3.0f; }
float HueOf(const glm::vec3& log_rgb) { return log_rgb.x - log_rgb.z; }
float GreenOf(const glm::vec3& log_rgb) { return log_rgb.y - 0.5f * (log_rgb.x + log_rgb.z); }

constexpr std::array<glm::ivec2, 4> kAround{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

class ShadeSearch {
 public:
  explicit ShadeSearch(const UnmodelledShadeInput& input)
      : input_(input),
        width_(input.view.Width()),
        height_(input.view.Height()),
        across_(std::max(2, width_ / 128)),
        is_usable_(width_, height_, 0),
        as_lit_(width_, height_, glm::vec3(0.0f)),
        step_(width_, height_, glm::vec3(0.0f)),
        has_step_(width_, height_, 0),
        part_(width_, height_, kNone) {
    tbb::parallel_for(0, height_, [&](int y) {
      for (int x = 0; x < width_; ++x) CompareWithLight(part_.Index(x, y));
    });
  }

  UnmodelledShade Find() {
    UnmodelledShade found{Gray8Image(width_, height_, 0), RgbImage(width_, height_), 0};
    tbb::parallel_for(0, height_, [&](int y) {
      for (int x = 0; x < width_; ++x) has_step_.At(x, y) = HasStepBeside({x, y}) ? 1 : 0;
    });
    std::int32_t parts = 0;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (part_.At(x, y) != kNone || has_step_.At(x, y) == 0) continue;
        const std::vector<glm::ivec2> pixels = Grow({x, y}, parts);
        const std::optional<float> brighter = LitBeside(pixels, parts);
        ++parts;
        if (!brighter) continue;
        for (const glm::ivec2& at : pixels) {
          const std::size_t i = Index(at);
          found.is_in_shade.pixels[i] = 1;
          found.albedo_rgb.pixels[i] = glm::exp(as_lit_.pixels[i] + step_.pixels[i] + *brighter);
        }
        found.pixels += pixels.size();
      }
    }
    FillBlur(found);
    return found;
  }

 private:
  static constexpr std::int32_t kNone = -1;

  std::size_t Index(const glm::ivec2& at) const { return part_.Index(at.x, at.y); }

  // Sets as_lit_, step_ and is_usable_ of a pixel.
  void CompareWithLight(std::size_t i) {
    const SurfaceView& view = input_.view;
    if (view.region.pixels[i] == SurfaceView::kNoRegion) return;
    if (input_.side.pixels[i] != ShadowSide::kLit) return;
    const glm::vec3& radiance = input_.radiance.pixels[i];
    const float cosine =
        std::max(glm::dot(view.normal_world.pixels[i], glm::vec3(view.sun_direction_enu)), 0.0f);
    const glm::vec3 shaded = input_.sky_irradiance_rgb * view.sky_response[0].pixels[i] +
                             input_.sun_irradiance_rgb * view.sun_bounce.pixels[i];
    const glm::vec3 lit = shaded + input_.sun_irradiance_rgb * cosine;
    if (!(std::min({radiance.x, radiance.y, radiance.z}) > 0.0f)) return;
    if (!(std::min({shaded.x, shaded.y, shaded.z}) > 0.0f)) return;
    step_.pixels[i] = glm::log(lit / shaded);
    if (!(HueOf(step_.pixels[i]) > kLeastHueStep)) return;
    if (!(LevelOf(step_.pixels[i]) > kLeastLevelStep)) return;
    as_lit_.pixels[i] = glm::log(std::numbers::pi_v<float> * radiance / lit);
    is_usable_.pixels[i] = 1;
  }

  // The pixel of the same plane that is `step` off; none where there is none that can be compared.
  std::optional<glm::ivec2> Beside(const glm::ivec2& at, const glm::ivec2& step) const {
    const glm::ivec2 there((at.x + step.x + width_) % width_, at.y + step.y);
    if (there.y < 0 || there.y >= height_) return std::nullopt;
    const std::size_t i = Index(at);
    const std::size_t j = Index(there);
    const SurfaceView& view = input_.view;
    const bool is_one_plane =
        is_usable_.pixels[j] != 0 && view.region.pixels[i] == view.region.pixels[j] &&
        glm::dot(view.normal_world.pixels[i], view.normal_world.pixels[j]) > kOnePlaneCosine;
    return is_one_plane ? std::optional(there) : std::nullopt;
  }

  // Whether `lit` may be the same surface in the sun as `shaded` in the shade.
  bool IsStep(const glm::ivec2& shaded, const glm::ivec2& lit) const {
    const glm::vec3 step = as_lit_.pixels[Index(lit)] - as_lit_.pixels[Index(shaded)];
    const glm::vec3& expected = step_.pixels[Index(shaded)];
    const float level = LevelOf(step) - LevelOf(expected);
    const float hue = HueOf(step);
    return level > -kLevelBelow && level < kLevelAbove && hue > kLeastHueShare * HueOf(expected) &&
           hue < kMostHueShare * HueOf(expected) + kHueSlack &&
           std::abs(GreenOf(step) - GreenOf(expected)) < kGreenSlack;
  }

  bool HasStepBeside(const glm::ivec2& at) const {
    if (is_usable_.pixels[Index(at)] == 0) return false;
    return std::any_of(kAround.begin(), kAround.end(), [&](const glm::ivec2& direction) {
      const auto there = Beside(at, across_ * direction);
      return there && IsStep(at, *there);
    });
  }

  // What is connected to `seed` and as dark and blue as it, or as the last pixel beside a step on
  // the way there, marked as `part`.
  std::vector<glm::ivec2> Grow(const glm::ivec2& seed, std::int32_t part) {
    std::vector<glm::ivec2> pixels{seed};
    std::vector<glm::vec3> like{as_lit_.pixels[Index(seed)]};
    part_.pixels[Index(seed)] = part;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      for (const glm::ivec2& direction : kAround) {
        const auto there = Beside(pixels[i], direction);
        if (!there || part_.pixels[Index(*there)] != kNone) continue;
        const glm::vec3 off = as_lit_.pixels[Index(*there)] - like[i];
        const float most_hue = kSameHueShare * HueOf(step_.pixels[Index(*there)]);
        if (!(std::abs(LevelOf(off)) < kSameLevel) || !(std::abs(HueOf(off)) < most_hue)) continue;
        part_.pixels[Index(*there)] = part;
        pixels.push_back(*there);
        like.push_back(has_step_.pixels[Index(*there)] != 0 ? as_lit_.pixels[Index(*there)]
                                                            : like[i]);
      }
    }
    return pixels;
  }

  // By how much the lit surface beside a part is brighter than the part without the sun, in the
  // median; none where the part is no shade.
  std::optional<float> LitBeside(const std::vector<glm::ivec2>& pixels, std::int32_t part) const {
    if (pixels.size() < kFewestPixels) return std::nullopt;
    std::size_t edges = 0;
    std::vector<double> brighter;
    std::vector<double> hue_share;
    std::vector<double> green_off;
    for (const glm::ivec2& at : pixels) {
      for (const glm::ivec2& direction : kAround) {
        const auto there = Beside(at, across_ * direction);
        if (!there || part_.pixels[Index(*there)] == part) continue;
        const glm::vec3 step = as_lit_.pixels[Index(*there)] - as_lit_.pixels[Index(at)];
        if (std::abs(LevelOf(step)) < kVisibleStep) continue;
        ++edges;
        if (!IsStep(at, *there)) continue;
        const glm::vec3& expected = step_.pixels[Index(at)];
        brighter.push_back(LevelOf(step) - LevelOf(expected));
        hue_share.push_back(HueOf(step) / HueOf(expected));
        green_off.push_back(GreenOf(step) - GreenOf(expected));
      }
    }
    if (brighter.size() < kFewestSteps ||
        static_cast<double>(brighter.size()) < kLeastShareOfBorder * static_cast<double>(edges)) {
      return std::nullopt;
    }
    const double hue = UpperMedianInPlace(hue_share);
    if (!(hue > kLeastMedianHueShare && hue < kMostMedianHueShare)) return std::nullopt;
    if (!(std::abs(UpperMedianInPlace(green_off)) < kMedianGreenSlack)) return std::nullopt;
    return static_cast<float>(UpperMedianInPlace(brighter));
  }

  // Between shade and sun a pixel has some of both: it takes the mean of the sunlit ones around.
  void FillBlur(UnmodelledShade& found) const {
    const Gray8Image is_near_shade = NearShade(found.is_in_shade);
    // Some 400 places around a pixel, however fine the map is: their mean has a twentieth of a
    // pixel's noise.
    const int stride = std::max(1, across_ / 8);
    const int reach = across_ + 2;
    Gray8Image is_blurred(width_, height_, 0);
    tbb::parallel_for(0, height_, [&](int y) {
      for (int x = 0; x < width_; ++x) {
        const std::size_t i = part_.Index(x, y);
        if (is_near_shade.pixels[i] == 0) continue;
        glm::vec3 sum(0.0f);
        int count = 0;
        for (int dy = -reach; dy <= reach; dy += stride) {
          for (int dx = -reach; dx <= reach; dx += stride) {
            const auto there = Beside({x, y}, {dx, dy});
            if (!there || found.is_in_shade.pixels[Index(*there)] != 0) continue;
            if (is_near_shade.pixels[Index(*there)] != 0) continue;
            sum += as_lit_.pixels[Index(*there)];
            ++count;
          }
        }
        if (count == 0) continue;
        is_blurred.pixels[i] = 1;
        found.albedo_rgb.pixels[i] = glm::exp(sum / static_cast<float>(count));
      }
    });
    for (std::size_t i = 0; i < is_blurred.pixels.size(); ++i) {
      if (is_blurred.pixels[i] == 0) continue;
      found.is_in_shade.pixels[i] = 1;
      ++found.pixels;
    }
  }

  // 1 where a usable pixel out of the shade has some of its plane less than across_ away in its row
  // or column.
  Gray8Image NearShade(const Gray8Image& is_in_shade) const {
    Gray8Image is_near(width_, height_, 0);
    const auto mark = [&](const glm::ivec2& at, const glm::ivec2& to_shade) {
      const std::size_t i = Index(at);
      if (is_usable_.pixels[i] != 0 && Beside(at, to_shade)) is_near.pixels[i] = 1;
    };
    tbb::parallel_for(0, height_, [&](int y) {
      for (const int forward : {1, -1}) {
        int since_shade = across_;
        // The row goes round: it begins with the end of the last lap.
        for (int k = -across_; k < width_; ++k) {
          const int x = ((forward * k) % width_ + width_) % width_;
          since_shade = is_in_shade.At(x, y) != 0 ? 0 : since_shade + 1;
          if (since_shade > 0 && since_shade < across_) mark({x, y}, {-forward * since_shade, 0});
        }
      }
    });
    tbb::parallel_for(0, width_, [&](int x) {
      for (const int forward : {1, -1}) {
        int since_shade = across_;
        for (int k = 0; k < height_; ++k) {
          const int y = forward > 0 ? k : height_ - 1 - k;
          since_shade = is_in_shade.At(x, y) != 0 ? 0 : since_shade + 1;
          if (since_shade > 0 && since_shade < across_) mark({x, y}, {0, -forward * since_shade});
        }
      }
    });
    return is_near;
  }

  const UnmodelledShadeInput& input_;
  int width_;
  int height_;
  int across_;  // Pixels from one side of an edge to the other.
  Gray8Image is_usable_;
  RgbImage as_lit_;      // Logarithm of the albedo that the sun would make of the radiance.
  RgbImage step_;        // And by how much it is larger in the shade.
  Gray8Image has_step_;  // Beside it to a sunlit pixel.
  Image<std::int32_t> part_;
};

}  // namespace

UnmodelledShade FindUnmodelledShade(const UnmodelledShadeInput& input) {
  return ShadeSearch(input).Find();
}

}  // namespace pleinair
