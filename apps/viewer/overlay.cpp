#include "apps/viewer/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace pleinair {
namespace {

constexpr std::array kOverlays = {
    OverlayDefinition{"sample residuals",
                      "Samples of the estimate: blue is darker than the model, red brighter, full "
                      "colour from 30 % on",
                      DrawSampleResiduals},
    OverlayDefinition{
        "sample kinds",
        "Samples of the estimate: yellow lit by the sun, blue shaded, red left out as "
        "outliers",
        DrawSampleKinds},
    OverlayDefinition{"albedo", "Albedo of real surfaces, as the survey found it", DrawAlbedo},
    OverlayDefinition{
        "normals", "Normals of real surfaces: red east, green north, blue up", DrawNormals},
    OverlayDefinition{"ambient weight",
                      "Share of the sky's light that arrives: dark blue 0, yellow 1",
                      DrawAmbientWeight},
    OverlayDefinition{"sun visibility",
                      "Share of the sun's disc that the model sees: black none, yellow all",
                      DrawSunVisibility},
    OverlayDefinition{"clipping",
                      "Red: clipped; blue: at the noise floor; grey: masked, or not finite",
                      DrawClipping},
    OverlayDefinition{
        "regions", "Surfaces in their own colours; bright where samples may be drawn", DrawRegions},
};

}  // namespace

std::span<const OverlayDefinition> Overlays() { return kOverlays; }

std::uint8_t DisplayCode(float linear) {
  const float value = std::clamp(linear, 0.0f, 1.0f);
  const float code =
      value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * code));
}

glm::u8vec4 ColourOfShare(float share) {
  constexpr std::array<glm::vec3, 4> kStops = {glm::vec3(38.0f, 20.0f, 90.0f),
                                               glm::vec3(20.0f, 110.0f, 140.0f),
                                               glm::vec3(70.0f, 190.0f, 100.0f),
                                               glm::vec3(250.0f, 230.0f, 60.0f)};
  const float place = 3.0f * std::clamp(share, 0.0f, 1.0f);
  const auto below = static_cast<std::size_t>(std::min(place, 2.0f));
  const float part = place - static_cast<float>(below);
  return {glm::u8vec3(glm::mix(kStops[below], kStops[below + 1], part) + 0.5f), 255};
}

glm::u8vec4 ColourOfDifference(float difference) {
  const float size = std::min(std::abs(difference), 1.0f);
  const glm::vec3 full =
      difference < 0.0f ? glm::vec3(30.0f, 70.0f, 230.0f) : glm::vec3(230.0f, 40.0f, 30.0f);
  return {glm::u8vec3(glm::mix(glm::vec3(250.0f), full, size) + 0.5f), 255};
}

void DrawMark(glm::ivec2 pixel, int radius_px, glm::u8vec4 colour, Rgba8Image& picture) {
  for (int dy = -radius_px; dy <= radius_px; ++dy) {
    for (int dx = -radius_px; dx <= radius_px; ++dx) {
      if (!picture.Contains(pixel.x + dx, pixel.y + dy)) continue;
      const bool is_rim = std::max(std::abs(dx), std::abs(dy)) == radius_px;
      picture.At(pixel.x + dx, pixel.y + dy) = is_rim ? glm::u8vec4(0, 0, 0, 255) : colour;
    }
  }
}

glm::dvec3 PredictedRadiance(const DiffuseSample& sample, const Lighting& lighting) {
  glm::dvec3 radiance = lighting.sun.irradiance_rgb * sample.sun_transport_rgb;
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    radiance += lighting.sky[k].irradiance_rgb * sample.sky_transport_rgb[k];
  }
  return radiance;
}

double RelativeResidual(const DiffuseSample& sample, const Lighting& lighting) {
  const glm::dvec3 predicted = PredictedRadiance(sample, lighting);
  double sum = 0.0;
  int channels = 0;
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(sample.radiance_stddev_rgb[c]) || !(predicted[c] > 0.0)) continue;
    sum += sample.radiance_rgb[c] / predicted[c] - 1.0;
    ++channels;
  }
  return channels > 0 ? sum / channels : 0.0;
}

}  // namespace pleinair
