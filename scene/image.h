// A plain image: pixels in memory, nothing else. For files see image_io.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

// height x width, row-major, top row first.
template <typename Pixel>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels;

  Image() = default;
  // Throws std::invalid_argument when a side is negative.
  Image(int width_px, int height_px, Pixel fill = Pixel{}) : width(width_px), height(height_px) {
    if (width_px < 0 || height_px < 0) {
      throw std::invalid_argument("image size " + std::to_string(width_px) + "x" +
                                  std::to_string(height_px) + ": sides must not be negative");
    }
    pixels.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), fill);
  }

  bool Empty() const { return pixels.empty(); }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  bool Contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  Pixel& At(int x, int y) { return pixels[Index(x, y)]; }
  const Pixel& At(int x, int y) const { return pixels[Index(x, y)]; }
};

using RgbImage = Image<glm::vec3>;  // Linear light.
using GrayImage = Image<float>;
using Rgb8Image = Image<glm::u8vec3>;  // Display code values.
using Gray8Image = Image<std::uint8_t>;

}  // namespace pleinair
