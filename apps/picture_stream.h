// Composites to other programs while a run goes on.
#pragma once

#include <cstddef>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/descriptor.h"
#include "scene/image.h"

namespace pleinair {

// "y4m:-" or "y4m:PATH": YUV4MPEG2, 4:4:4, full range, BT.601, at `frames_per_second` by name.
// "v4l2:/dev/videoN": a loopback device that other programs read as a camera: YUYV, limited range,
// BT.601.
class PictureStream {
 public:
  // Keeps what is in a file. Throws std::runtime_error, one line with the target: it cannot be
  // opened, or is no such name.
  explicit PictureStream(const std::string& target,
                         double frames_per_second = 30.0,
                         std::stop_token stop = {});

  // The first picture removes what was in a file. Waits for the reader; once `stop` is requested,
  // for a second. Throws std::runtime_error: the reader is gone or does not read, or a picture of
  // another size than the first.
  void Write(const Rgb8Image& picture);

 private:
  void Begin(const Rgb8Image& first);

  std::string target_;
  double frames_per_second_;
  std::stop_token stop_;
  bool is_device_ = false;
  Descriptor out_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace pleinair
