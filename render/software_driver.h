// Drivers of OpenGL that draw on the processor.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace pleinair {

// `renderer`: GL_RENDERER, as the driver names itself; null: no context, and false.
inline bool DrawsOnProcessor(const char* renderer) {
  constexpr std::array<std::string_view, 4> kDrivers{
      "llvmpipe", "softpipe", "SwiftShader", "Software Rasterizer"};
  if (renderer == nullptr) return false;
  return std::any_of(kDrivers.begin(), kDrivers.end(), [&](std::string_view driver) {
    return std::string_view(renderer).find(driver) != std::string_view::npos;
  });
}

}  // namespace pleinair
