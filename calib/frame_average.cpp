#include "calib/frame_average.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "scene/upper_median.h"

namespace pleinair {

void FrameAverage::Add(const RgbImage& radiance) {
  if (radiance.Empty()) throw std::invalid_argument("frame: expected a picture with pixels");
  if (frame_count_ == 0) {
    width_ = radiance.width;
    height_ = radiance.height;
    pixels_.resize(radiance.pixels.size());
  }
  if (radiance.width != width_ || radiance.height != height_) {
    throw std::invalid_argument(std::string("frame: expected ") + std::to_string(width_) + "x" +
                                std::to_string(height_) + " pixels as in the first, found " +
                                std::to_string(radiance.width) + "x" +
                                std::to_string(radiance.height));
  }
  ++frame_count_;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const glm::dvec3 value(radiance.pixels[i]);
    if (!std::isfinite(value.x) || !std::isfinite(value.y) || !std::isfinite(value.z)) {
      ++left_out_count_;
      continue;
    }
    Running& running = pixels_[i];
    ++running.count;
    const glm::dvec3 before = value - running.mean;
    running.mean += before / static_cast<double>(running.count);
    running.squared_deviation_sum += before * (value - running.mean);
  }
}

RgbImage FrameAverage::Mean() const {
  RgbImage mean(width_, height_);
  for (std::size_t i = 0; i < pixels_.size(); ++i) mean.pixels[i] = glm::vec3(pixels_[i].mean);
  return mean;
}

RgbImage FrameAverage::StandardError() const {
  RgbImage error(width_, height_, glm::vec3(std::numeric_limits<float>::infinity()));
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Running& running = pixels_[i];
    if (running.count < 2) continue;
    const double divisor = static_cast<double>(running.count) * (running.count - 1);
    for (int c = 0; c < 3; ++c) {
      error.pixels[i][c] =
          static_cast<float>(std::sqrt(running.squared_deviation_sum[c] / divisor));
    }
  }
  return error;
}

double FrameAverage::MedianScatter() const {
  std::vector<double> shares;
  for (const Running& running : pixels_) {
    if (running.count < 2 || !(running.mean.y > 0.0)) continue;
    shares.push_back(std::sqrt(running.squared_deviation_sum.y / (running.count - 1)) /
                     running.mean.y);
  }
  return UpperMedianInPlace(shares);
}

}  // namespace pleinair
