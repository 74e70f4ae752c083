#include "apps/camera_stand_in/pictures_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/response.h"
#include "datasets/frame_source.h"
#include "scene/frame.h"

namespace pleinair::stand_in {
namespace {

int OpenNamelessFile() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const int fd = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (fd >= 0) return fd;
  // Not every file system has files without a name.
  std::string path = (folder / "pleinair-pictures-XXXXXX").string();
  const int named = mkostemp(path.data(), O_CLOEXEC);
  if (named < 0) {
    throw std::runtime_error(folder.string() +
                             ": expected a folder for temporary files: " + std::strerror(errno));
  }
  unlink(path.c_str());
  return named;
}

void WriteAt(int fd, const cv::Mat& image, std::int64_t offset) {
  const auto* bytes = image.ptr<char>();
  std::size_t left = image.total() * image.elemSize();
  while (left > 0) {
    const ssize_t written = pwrite(fd, bytes, left, static_cast<off_t>(offset));
    if (written <= 0) {
      throw std::runtime_error(std::filesystem::temp_directory_path().string() +
                               ": cannot write the pictures: " + std::strerror(errno));
    }
    bytes += written;
    offset += written;
    left -= static_cast<std::size_t>(written);
  }
}

cv::Mat Resized(const cv::Mat& image, Size size) {
  if (image.cols == size.width && image.rows == size.height) return image;
  cv::Mat resized;
  cv::resize(image,
             resized,
             {size.width, size.height},
             0.0,
             0.0,
             size.width < image.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

cv::Mat CodesOf(const cv::Mat& linear) {
  static const ResponseCurve srgb = ResponseCurve::Srgb();
  cv::Mat codes(linear.size(), CV_8UC3);
  for (int y = 0; y < linear.rows; ++y) {
    for (int x = 0; x < linear.cols; ++x) {
      const auto& light = linear.at<cv::Vec3f>(y, x);
      const glm::u8vec3 code = srgb.CodeFromLinear({light[0], light[1], light[2]});
      codes.at<cv::Vec3b>(y, x) = {code.x, code.y, code.z};
    }
  }
  return codes;
}

// The next frame, which must be a good one.
Frame Next(FrameSource& source) {
  auto frame = source.Next();
  if (!frame) throw std::logic_error("fewer frames than the sequence has");
  if (!*frame) throw std::runtime_error(frame->error().reason);
  return std::move(**frame);
}

// 1 saturates the codes.
cv::Mat LinearPicture(Frame& frame) {
  const cv::Mat radiance(
      frame.radiance.height, frame.radiance.width, CV_32FC3, frame.radiance.pixels.data());
  return radiance * *frame.exposure;
}

constexpr float kMostHalf = 65504.0f;

}  // namespace

int WritePicturesFile(const Sequence& sequence, std::optional<Size> size, DeviceState& state) {
  const Size own{sequence.intrinsics.width_px, sequence.intrinsics.height_px};
  const auto& frames = sequence.frames;
  state.picture_count = static_cast<int>(frames.size());
  state.has_linear = std::all_of(frames.begin(), frames.end(), [](const FrameEntry& frame) {
    return frame.image.has_value() && frame.EffectiveExposure().has_value();
  });
  state.codes_follow =
      sequence.response_ldr == "srgb8" ||
      std::none_of(frames.begin(), frames.end(), [](const auto& f) { return f.image_ldr; });
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].image_ldr || frames[i].EffectiveExposure()) continue;
    throw std::runtime_error((sequence.folder / *frames[i].image).string() +
                             ": expected an exposure, or an 8-bit picture beside it");
  }
  state.levels[0].size = own;
  state.level_count = 1;
  if (size && *size != own)
    state.levels[static_cast<std::size_t>(state.level_count++)].size = *size;
  std::int64_t end = 0;
  for (int i = 0; i < state.level_count; ++i) {
    PictureLevel& level = state.levels[static_cast<std::size_t>(i)];
    const std::int64_t samples =
        std::int64_t{3} * level.size.width * level.size.height * state.picture_count;
    level.codes_offset = end;
    level.linear_offset = end + samples;
    end += samples * (state.has_linear ? 3 : 1);
  }

  const auto linear_source = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  const auto codes_source = MakeRecordedFrameSource(sequence, FrameKind::kLdr);
  const auto has_codes = [](const FrameEntry& frame) { return frame.image_ldr.has_value(); };
  const bool reads_codes = std::any_of(frames.begin(), frames.end(), has_codes);
  const bool reads_linear =
      state.has_linear || !std::all_of(frames.begin(), frames.end(), has_codes);
  const int fd = OpenNamelessFile();
  try {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      cv::Mat codes;
      cv::Mat linear;
      Frame of_linear;
      Frame of_codes;
      // Each source goes from frame to frame, so it is asked for all of them or for none.
      if (reads_linear) of_linear = Next(*linear_source);
      if (reads_codes) of_codes = Next(*codes_source);
      if (of_codes.codes) {
        codes = cv::Mat(
            of_codes.codes->height, of_codes.codes->width, CV_8UC3, of_codes.codes->pixels.data());
      }
      if (state.has_linear || codes.empty()) linear = LinearPicture(of_linear);
      for (int k = 0; k < state.level_count; ++k) {
        const PictureLevel& level = state.levels[static_cast<std::size_t>(k)];
        const std::int64_t samples = std::int64_t{3} * level.size.width * level.size.height;
        const auto picture = static_cast<std::int64_t>(i);
        const cv::Mat light = linear.empty() ? linear : Resized(linear, level.size);
        WriteAt(fd,
                codes.empty() ? CodesOf(light) : Resized(codes, level.size),
                level.codes_offset + picture * samples);
        if (!state.has_linear) continue;
        cv::Mat half;
        cv::Mat(cv::min(light, kMostHalf)).convertTo(half, CV_16F);
        WriteAt(fd, half, level.linear_offset + picture * samples * 2);
      }
    }
  } catch (...) {
    close(fd);
    throw;
  }
  return fd;
}

}  // namespace pleinair::stand_in
