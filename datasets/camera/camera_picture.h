// Converts a camera's bytes to a picture.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "datasets/camera/pixel_format.h"
#include "scene/image.h"

namespace pleinair {

// The codes of all formats but Bayer; grey ones have three equal channels.
//
// Accuracy      YUYV and NV12 to half a code of the exact matrix, colours of neighbours shared as
//               they were sampled (no smoothing).
// Returns error one line: too few bytes for the layout, a JPEG that is damaged or of another size,
// an impossible layout. Bytes after the picture are ignored. So are up to 16 bytes of padding
// before a marker of a JPEG, which webcams leave; damage after such padding is found only if the
// end is missing.
tl::expected<Rgb8Image, std::string> DecodeCodes(std::span<const std::byte> bytes,
                                                 const PictureLayout& layout);

// The conversion of raw codes to light.
struct RawDevelopment {
  // Code without light, and the least code that is clipped; as codes of the format's own bits.
  double black_level = 0.0;
  double white_level = 255.0;
  glm::dvec3 white_balance_rgb{1.0};  // Factors.

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// For a sensor whose driver states nothing: black is a 16th of the range (64 of 1023), as for most
// sensors of cameras and telephones.
RawDevelopment UsualDevelopment(int bits);

// A raw picture as linear light.
struct DevelopedPicture {
  // (code - black) / (white - black) times the white balance; noise around black may be negative.
  RgbImage signal_rgb;
  // 1 where one of the colours that a pixel was computed from is at the white level.
  Gray8Image clipped;
};

// Only for Bayer: bilinear demosaicing by OpenCV in 16 bits. Returns error as DecodeCodes.
tl::expected<DevelopedPicture, std::string> Develop(std::span<const std::byte> bytes,
                                                    const PictureLayout& layout,
                                                    const RawDevelopment& development);

}  // namespace pleinair
