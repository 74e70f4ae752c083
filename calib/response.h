// What a camera makes of light: linear exposure in [0, 1] to 8-bit code values and back.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// A monotone curve per channel.
class ResponseCurve {
 public:
  static ResponseCurve Srgb();
  // Reads {"format": "pleinair-response", "version": 1, "linear_of_code_rgb": [[256 values] x 3]}.
  // Throws std::runtime_error naming file, place and what was expected.
  static ResponseCurve FromFile(const std::filesystem::path& file);

  glm::vec3 LinearFromCode(const glm::u8vec3& code) const;
  // Nearest code; values are clipped to [0, 1] first, as the camera does. NaN gives 0.
  glm::u8vec3 CodeFromLinear(const glm::vec3& linear) const;

 private:
  std::array<std::array<float, 256>, 3> linear_of_code_{};
};

// Radiance = linear / exposure.
RgbImage RadianceFromCodes(const Rgb8Image& codes, const ResponseCurve& response, double exposure);
Rgb8Image CodesFromRadiance(const RgbImage& radiance,
                            const ResponseCurve& response,
                            double exposure);

}  // namespace pleinair
