// Pictures of a camera that does not exist, each another one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include <turbojpeg.h>

#include "datasets/camera/camera_capture.h"
#include "scene/image.h"

namespace pleinair::made_pictures {

// Noise of all codes: nothing that is lost stays hidden.
inline Rgb8Image Noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> code(0, 255);
  Rgb8Image picture(width, height);
  for (glm::u8vec3& pixel : picture.pixels) {
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(code(random));
  }
  return picture;
}

inline std::vector<std::byte> Bytes(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  return {bytes, bytes + size};
}

inline std::vector<std::byte> Jpeg(const Rgb8Image& picture) {
  tjhandle encoder = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(encoder,
              reinterpret_cast<const unsigned char*>(picture.pixels.data()),
              picture.width,
              0,
              picture.height,
              TJPF_RGB,
              &data,
              &size,
              TJSAMP_420,
              80,
              0);
  std::vector<std::byte> jpeg = Bytes(data, size);
  tjFree(data);
  tjDestroy(encoder);
  return jpeg;
}

// The `number`th picture of a camera with 30 a second.
inline CameraFrame Frame(PixelFormat format, int width, int height, int number) {
  const auto seed = static_cast<unsigned>(number);
  CameraFrame frame;
  CapturedBuffer& buffer = frame.buffer;
  buffer.layout = {format, width, height, width, {}};
  if (format.coding == PixelCoding::kYuyv) buffer.layout.stride_bytes = 2 * width;
  if (format.coding == PixelCoding::kRgb) buffer.layout.stride_bytes = 3 * width;
  if (format.coding == PixelCoding::kBayer && format.bits > 8) {
    buffer.layout.stride_bytes = 2 * width;
  }
  if (format.coding == PixelCoding::kMjpeg) {
    buffer.layout.stride_bytes = 0;
    buffer.bytes = Jpeg(Noise(width, height, seed));
  } else {
    // NV12 needs half as many rows again.
    const Rgb8Image noise = Noise(buffer.layout.stride_bytes, (height + 1) / 2, seed);
    buffer.bytes = Bytes(noise.pixels.data(), 3 * noise.pixels.size());
  }
  buffer.sequence = seed;
  buffer.monotonic_time = std::chrono::seconds(1000) + number * std::chrono::microseconds(33333);
  buffer.exposure = {0.004 + 1e-5 * number, 2.5};
  frame.time = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} +
               (buffer.monotonic_time - std::chrono::seconds(1000));
  return frame;
}

}  // namespace pleinair::made_pictures
