#include "scene/image_io.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene/half_float.h"
#include "scene/internal/encoded_image.h"
#include "scene/internal/exr_codec.h"
#include "scene/internal/picture_codes.h"
#include "scene/internal/picture_format.h"
#include "scene/internal/radiance_hdr.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

template <typename Pixel>
void RequirePixels(const std::filesystem::path& file, const Image<Pixel>& image) {
  if (image.Empty()) throw std::invalid_argument(file.string() + ": an image without pixels");
}

// Before the file is read: it may be a long video.
void RefuseUnlessOf(const std::filesystem::path& file,
                    std::initializer_list<PictureFormat> formats,
                    const char* expected) {
  const std::vector<std::byte> bytes = FirstBytes(file);
  const PictureFormat found = PictureFormatOf(bytes);
  if (std::find(formats.begin(), formats.end(), found) != formats.end()) return;
  RefuseFile(file,
             std::string("expected ") + expected + ", found " + std::string(DescribeBytes(bytes)));
}

Image<glm::u8vec4> DecodeDisplay(const std::filesystem::path& file) {
  RefuseUnlessOf(file, {PictureFormat::kPng, PictureFormat::kJpeg}, "a PNG or JPEG picture");
  return DecodePicture(file, ReadWholeFile(file));
}

// Writes what `encode` makes.
template <typename Encode>
void WriteEncoded(const std::filesystem::path& file, const Encode& encode) {
  std::vector<std::byte> bytes;
  try {
    bytes = encode();
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": cannot be encoded: " + OneLine(error.what()));
  }
  WriteWholeFile(file, bytes);
}

}  // namespace

bool HoldsRadiance(const std::filesystem::path& file) {
  const PictureFormat format = PictureFormatOf(FirstBytes(file));
  return format == PictureFormat::kExr || format == PictureFormat::kRadianceHdr;
}

std::string DescribeContent(const std::filesystem::path& file) {
  return std::string(DescribeBytes(FirstBytes(file)));
}

RgbImage ReadRadianceImage(const std::filesystem::path& file) {
  RefuseUnlessOf(file,
                 {PictureFormat::kExr, PictureFormat::kRadianceHdr},
                 "an OpenEXR or Radiance HDR picture");
  return PictureFormatOf(FirstBytes(file)) == PictureFormat::kExr
             ? ReadExr(file)
             : DecodeRadianceHdr(file, ReadWholeFile(file));
}

Rgb8Image ReadDisplayImage(const std::filesystem::path& file) {
  const Image<glm::u8vec4> codes = DecodeDisplay(file);
  Rgb8Image image(codes.width, codes.height);
  std::copy(codes.pixels.begin(), codes.pixels.end(), image.pixels.begin());
  return image;
}

Gray8Image ReadMaskImage(const std::filesystem::path& file) {
  const Image<glm::u8vec4> codes = DecodeDisplay(file);
  Gray8Image image(codes.width, codes.height);
  std::transform(
      codes.pixels.begin(), codes.pixels.end(), image.pixels.begin(), [](const glm::u8vec4& code) {
        return code.r;
      });
  return image;
}

ImageDefects DefectsOf(const RgbImage& image) {
  ImageDefects defects;
  for (const glm::vec3& pixel : image.pixels) {
    bool finite = true;
    bool negative = false;
    for (int channel = 0; channel < 3; ++channel) {
      finite = finite && std::isfinite(pixel[channel]);
      negative = negative || pixel[channel] < 0.0f;
    }
    if (!finite) {
      ++defects.not_finite;
    } else if (negative) {
      ++defects.negative;
    }
  }
  return defects;
}

ImageDefects RepairRadiance(RgbImage& image) {
  const ImageDefects defects = DefectsOf(image);
  if (defects.Count() == 0) return defects;
  glm::vec3 largest(0.0f);
  for (const glm::vec3& pixel : image.pixels) {
    for (int channel = 0; channel < 3; ++channel) {
      const float value = pixel[channel];
      if (std::isfinite(value)) largest[channel] = std::max(largest[channel], value);
    }
  }
  for (glm::vec3& pixel : image.pixels) {
    for (int channel = 0; channel < 3; ++channel) {
      float& value = pixel[channel];
      if (value == std::numeric_limits<float>::infinity()) {
        value = largest[channel];
      } else if (!(value >= 0.0f)) {
        value = 0.0f;
      }
    }
  }
  return defects;
}

void WriteExr(const std::filesystem::path& file, const RgbImage& image, ExrPrecision precision) {
  RequirePixels(file, image);
  if (precision == ExrPrecision::kHalf) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      for (int channel = 0; channel < 3; ++channel) {
        const float value = image.pixels[i][channel];
        if (std::isfinite(value) && std::abs(value) > kLargestHalf) {
          const std::size_t width = static_cast<std::size_t>(image.width);
          throw std::invalid_argument(file.string() + ": pixel (" + std::to_string(i % width) +
                                      ", " + std::to_string(i / width) + "): value " +
                                      std::to_string(value) +
                                      " does not fit half float, which ends at 65504");
        }
      }
    }
  }
  WriteEncoded(file, [&] { return EncodeExr(image, precision); });
}

void WriteHdr(const std::filesystem::path& file, const RgbImage& image) {
  RequirePixels(file, image);
  WriteWholeFile(file, EncodeRadianceHdr(image));
}

void WritePng(const std::filesystem::path& file, const Rgb8Image& image) {
  RequirePixels(file, image);
  WriteEncoded(file, [&] { return EncodePng(image); });
}

void WritePng(const std::filesystem::path& file, const Gray8Image& image) {
  RequirePixels(file, image);
  WriteEncoded(file, [&] { return EncodePng(image); });
}

void WriteJpeg(const std::filesystem::path& file, const Rgb8Image& image, int quality) {
  RequirePixels(file, image);
  if (quality < 0 || quality > 100) {
    throw std::invalid_argument(file.string() + ": quality " + std::to_string(quality) +
                                ": expected 0 to 100");
  }
  WriteEncoded(file, [&] { return EncodeJpeg(image, quality); });
}

std::vector<std::byte> JpegOf(const Rgb8Image& image, int quality) {
  return EncodeJpeg(image, quality);
}

}  // namespace pleinair
