// A camera's response: linear exposure in [0, 1] to 8-bit code values and back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Limits of 8-bit codes for measurements. Clipped from 254 on: a camera whose white is not quite at
// 255 (JPEG's rounding, a gain applied after clipping) puts clipped light one code below.
inline constexpr int kClippedFromCode = 254;
// Up to 2 the code is read noise and rounding: half a code is a quarter of the value or more.
inline constexpr int kNoiseFloorUpToCode = 2;

// The light in [0, 1] of each code of each channel (R, G, B).
using ResponseTable = std::array<std::array<float, 256>, 3>;

// A monotone curve per channel.
class ResponseCurve {
 public:
  static ResponseCurve Srgb();
  // Throws std::invalid_argument naming channel and code where the table leaves [0, 1], falls, or
  // has all values of a channel equal.
  static ResponseCurve FromTable(const ResponseTable& linear_of_code_rgb);
  // Reads {"format": "pleinair-response", "version": 1, "linear_of_code_rgb": [[256 values] x 3]};
  // each list in [0, 1], never falling, and not all equal.
  // Throws std::runtime_error naming file, place and what was expected.
  static ResponseCurve FromFile(const std::filesystem::path& file);

  // Returns the text of a file that FromFile reads back bit for bit.
  std::string FileText() const;

  const std::array<float, 256>& LinearOfCode(int channel) const {
    return channels_.at(static_cast<std::size_t>(channel)).linear_of_code;
  }
  // Returns the nearest code; values are clipped to [0, 1] first, as the camera does. NaN gives 0.
  // Among codes of the same light (a flat end of the curve) it is the highest.
  glm::u8vec3 CodeFromLinear(const glm::vec3& linear) const;

 private:
  static constexpr int kGuesses = 4096;
  struct Channel {
    std::array<float, 256> linear_of_code{};
    // Linear value from which on the code is at least its index + 1, ascending.
    std::array<float, 255> threshold_above_code{};
    // The code at the lower end of each of kGuesses equal parts of [0, 1]: the start of the search.
    std::array<std::uint8_t, kGuesses> guess{};

    // Thresholds and guesses from linear_of_code: only the values at the codes are known, so the
    // camera is assumed to change its code halfway between them.
    void FillThresholds();
    void FillGuesses();
    std::uint8_t Code(float linear) const;
  };
  std::array<Channel, 3> channels_{};
};

// Radiance = linear / exposure. Throws std::invalid_argument for an exposure that is not positive.
RgbImage RadianceFromCodes(const Rgb8Image& codes, const ResponseCurve& response, double exposure);
// A pixel of CodesFromRadiance; `exposure` is not checked.
glm::u8vec3 CodeFromRadiance(const glm::vec3& radiance,
                             const ResponseCurve& response,
                             double exposure);
Rgb8Image CodesFromRadiance(const RgbImage& radiance,
                            const ResponseCurve& response,
                            double exposure);

}  // namespace pleinair
