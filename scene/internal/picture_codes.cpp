#include "scene/internal/picture_codes.h"

#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <png.h>
#include <turbojpeg.h>
#include <zlib.h>

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

// libpng's errors end no process: they are exceptions, as its manual advises for C++.
[[noreturn]] void ThrowPngError(png_structp, png_const_charp why) {
  throw std::runtime_error(std::string("PNG: ") + why);
}
void IgnorePngWarning(png_structp, png_const_charp) {}

class PngWriter {
 public:
  PngWriter() {
    if (info_ == nullptr) throw std::bad_alloc();
    png_set_write_fn(png_, &encoded_, Append, nullptr);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  template <typename Pixel>
  std::vector<std::byte> Encode(const Image<Pixel>& image, int colour_type) {
    png_set_IHDR(png_,
                 info_,
                 static_cast<png_uint_32>(image.width),
                 static_cast<png_uint_32>(image.height),
                 8,
                 colour_type,
                 PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    // Neighbours' differences, and runs of them alone: quick, and small enough for pictures.
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png_, Z_BEST_SPEED);
    png_set_compression_strategy(png_, Z_RLE);
    png_write_info(png_, info_);
    for (int y = 0; y < image.height; ++y) {
      png_write_row(png_, reinterpret_cast<png_const_bytep>(&image.At(0, y)));
    }
    png_write_end(png_, info_);
    return std::move(encoded_);
  }

 private:
  static void Append(png_structp png, png_bytep data, std::size_t size) {
    auto& encoded = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    encoded.insert(encoded.end(), bytes, bytes + size);
  }

  std::vector<std::byte> encoded_;
  png_structp png_ =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, ThrowPngError, IgnorePngWarning);
  png_infop info_ = png_create_info_struct(png_);
};

}  // namespace

std::vector<std::byte> EncodePng(const Rgb8Image& image) {
  return PngWriter().Encode(image, PNG_COLOR_TYPE_RGB);
}

std::vector<std::byte> EncodePng(const Gray8Image& image) {
  return PngWriter().Encode(image, PNG_COLOR_TYPE_GRAY);
}

std::vector<std::byte> EncodeJpeg(const Rgb8Image& image, int quality) {
  const std::unique_ptr<void, decltype(&tjDestroy)> encoder(tjInitCompress(), &tjDestroy);
  unsigned char* encoded = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(encoder.get(),
                                 reinterpret_cast<const unsigned char*>(image.pixels.data()),
                                 image.width,
                                 0,
                                 image.height,
                                 TJPF_RGB,
                                 &encoded,
                                 &size,
                                 TJSAMP_420,
                                 quality,
                                 TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> freed(encoded, &tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(encoder.get()));
  const auto* bytes = reinterpret_cast<const std::byte*>(encoded);
  return {bytes, bytes + size};
}

Image<glm::u8vec4> DecodePicture(const std::filesystem::path& file,
                                 std::span<const std::byte> bytes) {
  return PictureFormatOf(bytes) == PictureFormat::kPng ? DecodePng(file, bytes)
                                                       : DecodeJpeg(file, bytes);
}

}  // namespace pleinair
