#include "apps/picture_stream.h"

#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "apps/video_output.h"

namespace pleinair {
namespace {

constexpr const char* kY4m = "y4m:";
constexpr const char* kDevice = "v4l2:";

struct Yuv {
  double y;
  double u;
  double v;
};

// BT.601, full range: y in [0, 255], u and v around 0.
Yuv YuvOf(const glm::u8vec3& rgb) {
  const double y = 0.299 * rgb.x + 0.587 * rgb.y + 0.114 * rgb.z;
  return {y, (rgb.z - y) / 1.772, (rgb.x - y) / 1.402};
}

std::byte Code(double value) {
  return static_cast<std::byte>(std::lround(std::min(std::max(value, 0.0), 255.0)));
}

}  // namespace

PictureStream::PictureStream(const std::string& target,
                             double frames_per_second,
                             std::stop_token stop)
    : target_(target), frames_per_second_(frames_per_second), stop_(std::move(stop)) {
  if (target.starts_with(kY4m)) {
    out_ = OpenForWriting(target.substr(std::strlen(kY4m)));
  } else if (target.starts_with(kDevice)) {
    is_device_ = true;
    out_ = OpenVideoOutput(target.substr(std::strlen(kDevice)), target);
  } else {
    throw std::runtime_error("--stream '" + target +
                             "': expected y4m:-, y4m:PATH or v4l2:/dev/videoN");
  }
}

void PictureStream::Begin(const Rgb8Image& first) {
  if (is_device_) {
    SetVideoOutput(out_, target_, first.width, first.height, frames_per_second_);
  } else {
    Truncate(out_, target_);
    const std::string header =
        fmt::format("YUV4MPEG2 W{} H{} F{}:1000 Ip A1:1 C444 XCOLORRANGE=FULL\n",
                    first.width,
                    first.height,
                    std::lround(1000.0 * frames_per_second_));
    WriteAll(out_, std::as_bytes(std::span(header)), target_, stop_);
  }
  width_ = first.width;
  height_ = first.height;
}

void PictureStream::Write(const Rgb8Image& picture) {
  if (width_ == 0) Begin(picture);
  if (picture.width != width_ || picture.height != height_) {
    throw std::runtime_error(
        fmt::format("{}: expected a picture of {}x{} as the first, found {}x{}",
                    target_,
                    width_,
                    height_,
                    picture.width,
                    picture.height));
  }
  const std::size_t pixels = picture.pixels.size();
  if (is_device_) {
    constexpr double kLuma = 219.0 / 255.0;
    constexpr double kChroma = 224.0 / 255.0;
    buffer_.resize(2 * pixels);
    for (std::size_t i = 0; i + 1 < pixels; i += 2) {
      const Yuv a = YuvOf(picture.pixels[i]);
      const Yuv b = YuvOf(picture.pixels[i + 1]);
      buffer_[2 * i] = Code(16.0 + kLuma * a.y);
      buffer_[2 * i + 1] = Code(128.0 + kChroma * 0.5 * (a.u + b.u));
      buffer_[2 * i + 2] = Code(16.0 + kLuma * b.y);
      buffer_[2 * i + 3] = Code(128.0 + kChroma * 0.5 * (a.v + b.v));
    }
  } else {
    constexpr std::string_view kFrame = "FRAME\n";
    buffer_.resize(kFrame.size() + 3 * pixels);
    std::memcpy(buffer_.data(), kFrame.data(), kFrame.size());
    std::byte* planes = buffer_.data() + kFrame.size();
    for (std::size_t i = 0; i < pixels; ++i) {
      const Yuv yuv = YuvOf(picture.pixels[i]);
      planes[i] = Code(yuv.y);
      planes[pixels + i] = Code(128.0 + yuv.u);
      planes[2 * pixels + i] = Code(128.0 + yuv.v);
    }
  }
  WriteAll(out_, buffer_, target_, stop_);
}

}  // namespace pleinair
