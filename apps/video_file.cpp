#include "apps/video_file.h"

#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace pleinair {

struct VideoFile::Impl {
  std::filesystem::path path;
  std::filesystem::path partial;  // OpenCV chooses the container by its ending.
  double frames_per_second;
  cv::VideoWriter writer;
  cv::Size size;  // Of the pictures.
};

VideoFile::VideoFile(std::filesystem::path path, double frames_per_second)
    : impl_(std::make_unique<Impl>()) {
  impl_->partial = path;
  impl_->partial.replace_extension(".partial.mp4");
  impl_->path = std::move(path);
  impl_->frames_per_second = frames_per_second;
}

VideoFile::~VideoFile() {
  impl_->writer.release();
  std::error_code ignored;
  std::filesystem::remove(impl_->partial, ignored);
}

void VideoFile::Add(const Rgb8Image& picture) {
  const cv::Size size(picture.width, picture.height);
  const cv::Size even(size.width + size.width % 2, size.height + size.height % 2);
  if (!impl_->writer.isOpened()) {
    impl_->size = size;
    // H.264 plays everywhere; MPEG-4's own codec is always built in.
    for (const char* code : {"avc1", "mp4v"}) {
      if (impl_->writer.open(impl_->partial.string(),
                             cv::CAP_FFMPEG,
                             cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]),
                             impl_->frames_per_second,
                             even)) {
        break;
      }
    }
    if (!impl_->writer.isOpened()) {
      throw std::runtime_error(impl_->path.string() +
                               ": no video encoder: expected OpenCV with FFmpeg, and a folder that "
                               "can be written");
    }
  }
  if (size != impl_->size) {
    throw std::runtime_error(impl_->path.string() + ": a picture of " + std::to_string(size.width) +
                             "x" + std::to_string(size.height) + ", expected " +
                             std::to_string(impl_->size.width) + "x" +
                             std::to_string(impl_->size.height) + " as the first");
  }
  // OpenCV does not write through its input; the cast is for its constructor alone.
  const cv::Mat rgb(
      size.height, size.width, CV_8UC3, const_cast<glm::u8vec3*>(picture.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::copyMakeBorder(
      bgr, bgr, 0, even.height - size.height, 0, even.width - size.width, cv::BORDER_REPLICATE);
  impl_->writer.write(bgr);
}

void VideoFile::Finish() {
  if (!impl_->writer.isOpened()) return;
  impl_->writer.release();
  std::error_code failed;
  std::filesystem::rename(impl_->partial, impl_->path, failed);
  if (failed) {
    throw std::runtime_error(impl_->path.string() + ": cannot be written: " + failed.message());
  }
}

}  // namespace pleinair
