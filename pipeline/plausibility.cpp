#include "pipeline/plausibility.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "scene/lighting.h"

namespace pleinair {
namespace {

// 0 where a channel is not a number.
float Brightest(const glm::vec3& rgb) {
  return std::isnan(rgb.r + rgb.g + rgb.b) ? 0.0f : std::max({rgb.r, rgb.g, rgb.b});
}

cv::Mat View(GrayImage& image) { return {image.height, image.width, CV_32F, image.pixels.data()}; }

// The largest value in each pixel's neighbourhood, the pixel included.
GrayImage LargestAround(GrayImage values, int reach_px) {
  GrayImage largest(values.width, values.height);
  if (values.Empty()) return largest;
  const cv::Mat into = View(largest);
  const cv::Size side(2 * reach_px + 1, 2 * reach_px + 1);
  cv::dilate(View(values), into, cv::getStructuringElement(cv::MORPH_RECT, side));
  return largest;
}

bool IsChange(std::uint8_t value, PixelChange change) {
  return value == static_cast<std::uint8_t>(change);
}

bool AreOfOneLight(const FrameFacts& a, const FrameFacts& b) {
  constexpr std::chrono::hours kSteadyFor{1};
  return std::chrono::abs(b.time - a.time) <= kSteadyFor && a.judged_sunshine == b.judged_sunshine;
}

double Step(double before, double after) {
  if (before == after) return 0.0;
  constexpr double kLargestFactor = 100.0;
  const double step = std::abs(std::log(after / before));
  return step <= std::log(kLargestFactor) ? step : std::log(kLargestFactor);  // Not a number, too.
}

double Contrast(const FrameFacts& frame) { return 1.0 + SunOverSky(frame); }

template <typename Value, typename IsComparable>
std::optional<double> LargestStep(const std::vector<FrameFacts>& frames,
                                  Value value,
                                  IsComparable is_comparable) {
  std::optional<double> largest;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameFacts& before = frames[i - 1];
    const FrameFacts& after = frames[i];
    if (!AreOfOneLight(before, after) || !is_comparable(before) || !is_comparable(after)) continue;
    largest = std::max(largest.value_or(0.0), Step(value(before), value(after)));
  }
  return largest;
}

}  // namespace

std::optional<double> UntouchedShare(const RgbImage& camera_radiance, const Composite& composite) {
  std::size_t outside = 0;
  std::size_t untouched = 0;
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (!IsChange(composite.change.pixels[i], PixelChange::kNone)) continue;
    ++outside;
    const glm::vec3& was = camera_radiance.pixels[i];
    const glm::vec3& is = composite.radiance.pixels[i];
    untouched += was == is || (std::isnan(was.x + was.y + was.z) && std::isnan(is.x + is.y + is.z));
  }
  if (outside == 0) return std::nullopt;
  return static_cast<double>(untouched) / static_cast<double>(outside);
}

std::int64_t CountGlowingPixels(const RgbImage& camera_radiance, const Composite& composite) {
  constexpr int kAroundPx = 16;
  constexpr float kMostTimes = 2.0f;
  const Gray8Image& change = composite.change;
  GrayImage sources(change.width, change.height);
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    float& source = sources.pixels[i];
    source = Brightest(camera_radiance.pixels[i]);
    if (IsChange(change.pixels[i], PixelChange::kCovered)) {
      source = std::max(source, Brightest(composite.radiance.pixels[i]));
    }
  }
  const GrayImage around = LargestAround(std::move(sources), kAroundPx);
  std::int64_t count = 0;
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (!IsChange(change.pixels[i], PixelChange::kScaled)) continue;
    const glm::vec3& rgb = composite.radiance.pixels[i];
    const bool is_finite = std::isfinite(rgb.r) && std::isfinite(rgb.g) && std::isfinite(rgb.b);
    const float limit = kMostTimes * around.pixels[i];
    count += is_finite && Brightest(rgb) <= limit ? 0 : 1;
  }
  return count;
}

std::optional<double> SkyHue(const FrameFacts& frame) {
  const glm::dvec3& sky = frame.sky_irradiance_rgb;
  const double largest = std::max({sky.r, sky.g, sky.b});
  if (!(largest > 0.0)) return std::nullopt;
  return std::min({sky.r, sky.g, sky.b}) / largest;
}

double SunOverSky(const FrameFacts& frame) {
  const double sun = MeanOf(frame.sun_irradiance_rgb);
  return sun > 0.0 ? sun / MeanOf(frame.sky_irradiance_rgb) : 0.0;
}

bool ShowsSun(const FrameFacts& frame) {
  constexpr double kSunshine = 0.3;
  return SunOverSky(frame) >= kSunshine;
}

std::optional<double> LargestContrastStep(const std::vector<FrameFacts>& frames) {
  return LargestStep(frames, Contrast, [](const FrameFacts&) { return true; });
}

std::optional<double> LargestSkyStep(const std::vector<FrameFacts>& frames) {
  return LargestStep(
      frames,
      [](const FrameFacts& frame) { return MeanOf(frame.sky_irradiance_rgb); },
      [](const FrameFacts& frame) { return frame.has_common_unit; });
}

}  // namespace pleinair
