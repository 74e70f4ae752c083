// The mean of noisy HDR frames of a fixed camera.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Takes frames one by one and keeps sums only.
class FrameAverage {
 public:
  // A pixel with a channel that is not finite is left out of that frame's share. Throws
  // std::invalid_argument for an empty frame or one of another size than the first.
  void Add(const RgbImage& radiance);

  int FrameCount() const { return frame_count_; }
  // Pixels left out so far, over all frames.
  std::int64_t LeftOutCount() const { return left_out_count_; }

  // 0 where every frame's pixel was left out.
  RgbImage Mean() const;
  // Standard error of the mean, from the frames' scatter: falls with the root of their number.
  // Infinite where fewer than two frames count.
  RgbImage StandardError() const;
  // How far the frames are apart: their standard deviation as a share of the mean, the median over
  // the pixels' green. 0 for one frame.
  double MedianScatter() const;

 private:
  // Running mean and sum of squared deviations (Welford 1962): no cancellation however small the
  // noise.
  struct Running {
    glm::dvec3 mean{0.0};
    glm::dvec3 squared_deviation_sum{0.0};
    int count = 0;
  };
  int width_ = 0;
  int height_ = 0;
  int frame_count_ = 0;
  std::int64_t left_out_count_ = 0;
  std::vector<Running> pixels_;
};

}  // namespace pleinair
