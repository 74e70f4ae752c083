// Judges a run's light and pictures without ground truth, by how plausible they are.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "render/compositor.h"
#include "scene/image.h"
#include "scene/utc_time.h"

namespace pleinair {

// One frame that was processed.
struct FrameFacts {
  UtcTime time{};
  glm::dvec3 sun_irradiance_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal.
  // Whether the light is in the unit of the frames before and after.
  bool has_common_unit = true;
  bool light_is_known = true;  // LightIsKnown.
  // A person's judgement of the picture; none where there is none.
  std::optional<bool> judged_sunshine;
  // None where light was not measured from samples.
  std::optional<double> inlier_fraction;
  std::optional<double> relative_residual;
  // The following are none without pictures. Share of the pixels outside the composite's own mask
  // that are the camera's; also none where the composite has changed every pixel.
  std::optional<double> untouched_share;
  std::optional<std::int64_t> glowing_pixels;  // CountGlowingPixels.
  std::optional<std::int64_t> clamped_pixels;  // FrameResult's.
};

// None where the composite has changed every pixel.
std::optional<double> UntouchedShare(const RgbImage& camera_radiance, const Composite& composite);

// Counts real pixels that the composite made brighter than anything around can make them. Their
// brightest channel is more than twice that of any pixel of the camera's picture, or of the object,
// within 16 px; or it is not finite.
std::int64_t CountGlowingPixels(const RgbImage& camera_radiance, const Composite& composite);

// Smallest over largest channel; none of a black sky.
std::optional<double> SkyHue(const FrameFacts& frame);

// Sun (normal to the beam) over sky (horizontal), means over RGB; infinite without a sky, 0 without
// any light.
double SunOverSky(const FrameFacts& frame);

// Whether the light casts shadows that a person notices: a beam of at least 0.3 times the sky.
// Sunshine is a beam of 120 W m^-2 and more (World Meteorological Organization, Guide to
// Instruments, part I, chapter 8). Bright skies that hide the sun have up to some 400 W m^-2.
bool ShowsSun(const FrameFacts& frame);

// The largest change of light from a frame to the next one, as |log ratio|, at most log(100). It is
// over pairs of successive frames not more than an hour apart between which no judgement of
// sunshine changes. None without such a pair.
//
// Contrast is 1 + SunOverSky: the factor by which sunlight brightens a surface that faces the sun,
// defined without a sun, too. The sky's step needs a common unit.
std::optional<double> LargestContrastStep(const std::vector<FrameFacts>& frames);
std::optional<double> LargestSkyStep(const std::vector<FrameFacts>& frames);

}  // namespace pleinair
