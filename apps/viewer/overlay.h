// Pictures laid over the composite: what the program sees in each pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "estimation/diffuse_sample.h"
#include "pipeline/frame_pipeline.h"
#include "scene/frame.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

using Rgba8Image = Image<glm::u8vec4>;  // Display code values; not premultiplied.

// One frame that was estimated. References live for the call only.
struct OverlayInput {
  const Frame& frame;
  const FrameResult& result;
  const SurfaceView& view;
  std::span<const DiffuseSample> samples;
};

// Returns a picture of the view's size.
using DrawOverlay = Rgba8Image (*)(const OverlayInput&);

struct OverlayDefinition {
  const char* name;
  const char* help;  // What its colours say, in a line.
  DrawOverlay draw;
};

// In the order of their keys: Alt+1 shows the first.
std::span<const OverlayDefinition> Overlays();

// overlays/, a file each.
Rgba8Image DrawSampleResiduals(const OverlayInput& input);
Rgba8Image DrawSampleKinds(const OverlayInput& input);
Rgba8Image DrawAlbedo(const OverlayInput& input);
Rgba8Image DrawNormals(const OverlayInput& input);
Rgba8Image DrawAmbientWeight(const OverlayInput& input);
Rgba8Image DrawSunVisibility(const OverlayInput& input);
Rgba8Image DrawClipping(const OverlayInput& input);
Rgba8Image DrawRegions(const OverlayInput& input);

// What overlays share.
inline constexpr glm::u8vec4 kNoColour{0, 0, 0, 0};
// Linear in [0, 1] as a code value of sRGB.
std::uint8_t DisplayCode(float linear);
// 0 to 1: dark blue, green, yellow; lightness rises evenly.
glm::u8vec4 ColourOfShare(float share);
// -1 to 1: blue (too dark), white, red (too bright).
glm::u8vec4 ColourOfDifference(float difference);
// A filled square with a dark rim, `radius_px` to each side.
void DrawMark(glm::ivec2 pixel, int radius_px, glm::u8vec4 colour, Rgba8Image& picture);
// Radiance of one sample by the model, under the frame's own estimate.
glm::dvec3 PredictedRadiance(const DiffuseSample& sample, const Lighting& lighting);
// (measured - predicted) / predicted, mean over the channels that are not clipped.
double RelativeResidual(const DiffuseSample& sample, const Lighting& lighting);

}  // namespace pleinair
