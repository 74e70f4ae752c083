#include "scene/internal/exr_codec.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <sstream>
#include <stdexcept>
#include <string>

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>
#include <half.h>

#include "scene/internal/encoded_image.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

constexpr const char* kChannels[3] = {"R", "G", "B"};

void RequireRgb(const std::filesystem::path& file, const Imf::Header& header) {
  for (const char* name : kChannels) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr) {
      RefuseFile(file, std::string("no channel ") + name + ": expected an image with R, G and B");
    }
    if (channel->xSampling != 1 || channel->ySampling != 1) {
      RefuseFile(file,
                 std::string("channel ") + name + " is sub-sampled: expected full resolution");
    }
  }
}

struct Window {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

Window WindowOf(const Imath::Box2i& box) {
  return {box.min.x,
          box.min.y,
          static_cast<std::int64_t>(box.max.x) - box.min.x + 1,
          static_cast<std::int64_t>(box.max.y) - box.min.y + 1};
}

std::string Text(const Window& window) {
  return std::to_string(window.width) + "x" + std::to_string(window.height) + " at (" +
         std::to_string(window.x) + ", " + std::to_string(window.y) + ")";
}

RgbImage Crop(const RgbImage& image, const Window& data, const Window& display) {
  RgbImage cropped(static_cast<int>(display.width), static_cast<int>(display.height));
  for (int y = 0; y < cropped.height; ++y) {
    const auto from =
        image.pixels.begin() + (display.y - data.y + y) * data.width + (display.x - data.x);
    std::copy_n(from, cropped.width, cropped.pixels.begin() + y * display.width);
  }
  return cropped;
}

RgbImage ReadPixels(const std::filesystem::path& file) {
  Imf::InputFile input(file.c_str());
  const Imf::Header& header = input.header();
  RequireRgb(file, header);
  const Window data = WindowOf(header.dataWindow());
  const Window display = WindowOf(header.displayWindow());
  RequireImageSize(file, data.width, data.height, std::filesystem::file_size(file));
  if (display.width < 1 || display.height < 1 || display.x < data.x || display.y < data.y ||
      display.x + display.width > data.x + data.width ||
      display.y + display.height > data.y + data.height) {
    RefuseFile(file,
               "data window " + Text(data) + " does not cover the display window " + Text(display));
  }
  if (!input.isComplete()) RefuseFile(file, "the OpenEXR file is truncated");

  RgbImage image(static_cast<int>(data.width), static_cast<int>(data.height));
  const std::size_t pixel_stride = sizeof(glm::vec3);
  const std::size_t row_stride = pixel_stride * static_cast<std::size_t>(data.width);
  Imf::FrameBuffer frame;
  for (int channel = 0; channel < 3; ++channel) {
    frame.insert(kChannels[channel],
                 Imf::Slice::Make(Imf::FLOAT,
                                  &image.pixels.front()[channel],
                                  header.dataWindow(),
                                  pixel_stride,
                                  row_stride));
  }
  input.setFrameBuffer(frame);
  input.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  const bool fills_display = data.x == display.x && data.y == display.y &&
                             data.width == display.width && data.height == display.height;
  return fills_display ? image : Crop(image, data, display);
}

}  // namespace

RgbImage ReadExr(const std::filesystem::path& file) {
  try {
    return ReadPixels(file);
  } catch (const std::exception& error) {
    // Ours begin with the file's name, OpenEXR's with whatever its parts had to say.
    const std::string message = OneLine(error.what());
    if (message.starts_with(file.string() + ": ")) throw;
    RefuseFile(file, "not a readable OpenEXR image (" + message + ")");
  }
}

std::vector<std::byte> EncodeExr(const RgbImage& image, ExrPrecision precision) {
  const bool as_half = precision == ExrPrecision::kHalf;
  const Imf::PixelType type = as_half ? Imf::HALF : Imf::FLOAT;
  std::vector<half> halves;
  if (as_half) {
    halves.reserve(image.pixels.size() * 3);
    for (const glm::vec3& pixel : image.pixels) {
      for (int channel = 0; channel < 3; ++channel) halves.emplace_back(pixel[channel]);
    }
  }
  const std::size_t value_size = as_half ? sizeof(half) : sizeof(float);
  // The frame buffer of an output file is only read, but its type does not say so.
  const void* const values =
      as_half ? static_cast<const void*>(halves.data()) : image.pixels.data();
  char* const base = static_cast<char*>(const_cast<void*>(values));

  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    header.channels().insert(kChannels[channel], Imf::Channel(type));
    frame.insert(kChannels[channel],
                 Imf::Slice(type,
                            base + channel * value_size,
                            3 * value_size,
                            3 * value_size * static_cast<std::size_t>(image.width)));
  }
  Imf::StdOSStream stream;
  {
    // Closing writes the table of lines. In memory, because OpenEXR's file stream keeps a full disc
    // to itself there.
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(frame);
    output.writePixels(image.height);
  }
  const std::string text = stream.str();
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  return {bytes, bytes + text.size()};
}

}  // namespace pleinair
