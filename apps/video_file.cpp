#include "apps/video_file.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace pleinair {
namespace {

int EvenFrom(int side_px) { return side_px + side_px % 2; }

// The last row and column again, where a side is odd.
Rgb8Image Even(const Rgb8Image& picture) {
  Rgb8Image even(EvenFrom(picture.width), EvenFrom(picture.height));
  for (int y = 0; y < even.height; ++y) {
    for (int x = 0; x < even.width; ++x) {
      even.At(x, y) = picture.At(std::min(x, picture.width - 1), std::min(y, picture.height - 1));
    }
  }
  return even;
}

}  // namespace

VideoFile::VideoFile(std::filesystem::path path, double frames_per_second)
    : path_(std::move(path)), partial_(path_), frames_per_second_(frames_per_second) {
  partial_.replace_extension(".partial.mp4");
}

VideoFile::~VideoFile() {
  writer_.reset();
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void VideoFile::Add(const Rgb8Image& picture) {
  if (!writer_) {
    width_px_ = picture.width;
    height_px_ = picture.height;
    std::error_code ignored;  // One that a killed run left.
    std::filesystem::remove(partial_, ignored);
    VideoFormat format;
    format.codec = VideoCodec::kH264;
    format.width_px = EvenFrom(width_px_);
    format.height_px = EvenFrom(height_px_);
    format.container = VideoContainer::kMp4;
    format.frames_per_second = frames_per_second_;
    writer_.emplace(partial_, format);
  }
  if (picture.width != width_px_ || picture.height != height_px_) {
    throw std::runtime_error(fmt::format("{}: a picture of {}x{}, expected {}x{} as the first",
                                         path_.string(),
                                         picture.width,
                                         picture.height,
                                         width_px_,
                                         height_px_));
  }
  const auto time = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(count_ / frames_per_second_));
  const bool is_even = width_px_ % 2 == 0 && height_px_ % 2 == 0;
  is_whole_ = false;
  writer_->Add(is_even ? picture : Even(picture), time);
  is_whole_ = true;
  ++count_;
}

void VideoFile::Finish() {
  if (!is_whole_) return;
  writer_->Finish();
  writer_.reset();
  is_whole_ = false;
  std::error_code failed;
  std::filesystem::rename(partial_, path_, failed);
  if (failed) {
    throw std::runtime_error(path_.string() + ": cannot be written: " + failed.message());
  }
}

}  // namespace pleinair
