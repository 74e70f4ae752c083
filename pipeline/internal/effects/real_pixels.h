// A frame's real pixels: radiance of the camera and of the model.
#pragma once

#include <cstddef>
#include <optional>

#include <glm/vec3.hpp>

#include "pipeline/internal/effects/frame_effect.h"
#include "render/real_sun.h"

namespace pleinair {

// The model's light on a real pixel without virtual objects.
struct PixelLight {
  glm::vec3 indirect{0.0f};
  glm::vec3 direct{0.0f};  // With all of the disc visible.
};
PixelLight LightOfPixel(const EffectFrame& frame, std::size_t pixel);

// The largest difference, over the channels, of the codes that a pixel has in one light and
// another.
float CodesBetween(const EffectFrame& frame,
                   std::size_t pixel,
                   const glm::vec3& radiance,
                   const glm::vec3& other);

bool IsClipped(const Frame& frame, std::size_t pixel);

// The data for the decision whether the pixel has sun.
RealPixel RealPixelOf(const EffectFrame& frame, std::size_t pixel, const PixelLight& light);

// Share of the disc that the pixel sees without virtual objects.
float SunSeenWithout(const EffectFrame& frame, std::size_t pixel, const RealPixel& state);

// Whether a pixel that the mesh has in the sun is in the sun. None where that cannot be said: the
// mesh has it in shade, or it is too dark for its surface even in shade and shows something else.
std::optional<bool> LooksSunlit(const EffectFrame& frame, std::size_t pixel);

}  // namespace pleinair
