// Light in code values of the camera's 8-bit picture: the unit of visible changes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "calib/response.h"
#include "calib/response_correction.h"
#include "scene/frame.h"
#include "scene/image.h"

namespace pleinair {

inline constexpr double kWhiteCode = 255.0;

// Returns an exposure, from radiance to [0, 1], for frames that do not state theirs: 95 % of a
// linear picture's pixels are then below 0.8 of white. 1 for a picture without light.
double ChosenExposure(const RgbImage& radiance);
// The same of a frame: 8-bit ones of unknown exposure are in units of their own [0, 1].
double ChosenExposure(const Frame& frame);

// Continuous code values, 0 to 255, clipped at white; linear between the light of the codes.
class DisplayCodes {
 public:
  // Of light that `correction` makes of grey pixels; veil and vignetting are left out, and what
  // saturation makes of light that is not grey, but for LargestRise.
  // Throws std::invalid_argument for an exposure that is not positive and finite.
  DisplayCodes(const ResponseCurve& response,
               double exposure,
               const ResponseCorrection& correction = {});

  void SetExposure(double exposure);
  double Exposure() const { return exposure_; }

  // The code value of a radiance in a channel; NaN gives 0.
  float Code(int channel, float radiance) const;
  // The largest difference between codes of two radiances, over the channels.
  float Difference(const glm::vec3& a, const glm::vec3& b) const;
  // Upper bound of the change of a code where radiance of at least `least` grows by up to `added`.
  // It uses a concave curve that is nowhere flatter than the camera's. For a concave curve, as
  // sRGB's is, it is the largest possible change.
  float LargestRise(const glm::vec3& least, const glm::vec3& added) const;

 private:
  static constexpr int kGuesses = 1024;
  struct Channel {
    std::array<float, 256> linear_of_code{};
    // The curve of LargestRise, where the camera's has its codes.
    std::array<float, 256> steep_code{};
    // The last code at or below the lower end of each of kGuesses equal parts of [0, 1].
    std::array<std::uint8_t, kGuesses> guess{};
  };
  float On(const std::array<float, 256>& values, const Channel& channel, float radiance) const;

  std::array<Channel, 3> channels_;
  float saturated_rise_ = 1.0f;  // At most, of a channel by itself.
  double exposure_ = 1.0;
  float scale_ = 1.0f;  // The exposure.
};

}  // namespace pleinair
