// Puts the layers into the camera's picture by the processor.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "render/compositor.h"
#include "render/internal/blur_kernel.h"
#include "render/internal/composite_pass.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/screen_extent.h"

namespace pleinair {

// Part of a layer, zero elsewhere.
template <typename Value>
struct LayerPart {
  PixelRect rect;
  std::vector<Value> values;  // Row-major over rect.
};

// A pixel's share of new shadow, by a mask of the layers: see CompositePass.
float ShadowByMask(const LayerPart<float>& mask, const LayerLookup& lookup, int x, int y);

// The input: as CompositeLayers, in memory.
struct ProcessorLayers {
  const LayerLookup& lookup;
  LayerPart<glm::vec4> object;     // Radiance times coverage in the layers' units, and coverage.
  LayerPart<float> mask;           // New shadow by volumes, 0 or 1.
  const RealSunShare* hidden_sun;  // New shadow by shares of the sun's disc; or null.
  BlurKernel shadow_blur;          // Blur of the shares of the sun's disc.
  PixelRect object_rect;           // Where in the camera's picture they can matter.
  PixelRect mask_rect;
};

// Does the work of CompositePass, without its rounding to half floats. Before the call,
// result.radiance is the camera's picture and result.change is kNone. input.lighting is not used:
// `light` and `gain` replace it, in the layers' units.
//
// Where the processor also draws for OpenGL, this takes a tenth of the pass's time. Its input is in
// memory anyway, only pixels that change are read, and the test for sun is done only where it
// matters.
//
// Threads  The result does not depend on their number.
void CompositeByProcessor(const CompositeInput& input,
                          const ProcessorLayers& layers,
                          const CompositeLight& light,
                          float gain,
                          Composite& result);

}  // namespace pleinair
