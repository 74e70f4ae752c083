#include "scene/internal/picture_codes.h"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <png.h>
#include <turbojpeg.h>

#include "scene/internal/encoded_image.h"
#include "scene/internal/picture_format.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

[[noreturn]] void RefuseDamaged(const std::filesystem::path& file,
                                const char* format,
                                const char* why) {
  RefuseFile(file, std::string("the ") + format + " image is damaged (" + OneLine(why) + ")");
}

Image<glm::u8vec4> DecodePng(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  const std::vector<std::byte> stripped = CheckedPng(file, bytes);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, decltype(&png_image_free)> freed(&header, &png_image_free);
  if (png_image_begin_read_from_memory(&header, stripped.data(), stripped.size()) == 0) {
    RefuseDamaged(file, "PNG", header.message);
  }
  header.format = PNG_FORMAT_RGBA;
  Image<glm::u8vec4> image(static_cast<int>(header.width), static_cast<int>(header.height));
  if (png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr) == 0) {
    RefuseDamaged(file, "PNG", header.message);
  }
  return image;
}

Image<glm::u8vec4> DecodeJpeg(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  CheckJpeg(file, bytes);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), &tjDestroy);
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(
          decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours) != 0) {
    RefuseDamaged(file, "JPEG", tjGetErrorStr2(decoder.get()));
  }
  if (colours == TJCS_CMYK || colours == TJCS_YCCK) {
    RefuseFile(file, "the JPEG image has CMYK colours: expected grey or RGB");
  }
  Image<glm::u8vec4> image(width, height);
  auto* const codes = reinterpret_cast<unsigned char*>(image.pixels.data());
  // Each scan of a progressive picture goes over all of it: at most 500, or one file takes hours.
  if (tjDecompress2(decoder.get(),
                    data,
                    bytes.size(),
                    codes,
                    width,
                    0,
                    height,
                    TJPF_RGBA,
                    TJFLAG_LIMITSCANS) != 0) {
    const std::string_view why = tjGetErrorStr2(decoder.get());
    const bool is_harmless = tjGetErrorCode(decoder.get()) == TJERR_WARNING &&
                             why.find("extraneous bytes") != std::string_view::npos;
    if (!is_harmless) RefuseDamaged(file, "JPEG", why.data());
  }
  return image;
}

}  // namespace

Image<glm::u8vec4> DecodePicture(const std::filesystem::path& file,
                                 std::span<const std::byte> bytes) {
  return PictureFormatOf(bytes) == PictureFormat::kPng ? DecodePng(file, bytes)
                                                       : DecodeJpeg(file, bytes);
}

}  // namespace pleinair
