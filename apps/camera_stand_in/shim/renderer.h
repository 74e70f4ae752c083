// Turns a stored picture into a buffer of any of the stand-in's formats.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "apps/camera_stand_in/device_state.h"

namespace pleinair::stand_in {

struct PixelFormatInfo {
  std::uint32_t pixel_format;
  const char* description;
};
std::span<const PixelFormatInfo> PixelFormats();
bool HasPixelFormat(std::uint32_t pixel_format);
// Chroma subsampling, mosaics and packing want even sides, or a width in fours.
bool Fits(std::uint32_t pixel_format, Size size);
// 0 for a compressed format.
std::size_t BytesPerLine(const Format& format);
std::size_t BufferBytes(const Format& format);

struct Shot {
  int picture = 0;  // In the file.
  Gains gains{1.0f, 1.0f, 1.0f};
};

// Keeps its scratch memory and look-up tables from picture to picture.
class Renderer {
 public:
  Renderer(const DeviceState& state, int pictures_fd) : state_(state), pictures_fd_(pictures_fd) {}
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer();

  // Returns the bytes used, 0 where the pictures cannot be read. Reads only the set-up of the
  // state, so it needs no lock.
  std::size_t Render(const Shot& shot, const Format& format, std::span<std::uint8_t> out);

 private:
  // What a stored sample gives, by channel.
  struct Tables {
    bool from_linear = false;
    int bits = 0;  // Depth of raw values; 0: display codes.
    Gains gains{};
    std::array<std::vector<std::uint16_t>, 3> value_of;
  };
  const Tables& TablesFor(bool from_linear, int bits, const Gains& gains);
  // Fills rgb_ at `size`: display codes, or raw values of so many bits.
  bool Fill(const Shot& shot, Size size, int bits);
  bool Read(std::int64_t offset, std::size_t bytes);
  std::size_t Compress(Size size, std::span<std::uint8_t> out);

  const DeviceState& state_;
  int pictures_fd_;
  std::vector<std::uint8_t> stored_;
  std::vector<std::uint16_t> rgb_, level_rgb_;
  Tables tables_;
  void* jpeg_ = nullptr;
};

}  // namespace pleinair::stand_in
