// Reads pictures of a video file.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "scene/image.h"
#include "scene/utc_time.h"

namespace pleinair {

// One picture of a video.
struct VideoPicture {
  // With the file's matrix and range; where it states none, BT.709 from 720 rows on, else BT.601.
  // Rotation is not applied: intrinsics refer to the sensor's rows and columns.
  Rgb8Image codes;
  std::chrono::nanoseconds time{0};  // Time of presentation, from the start of the file.
};

// Reads the common containers (Matroska, WebM, MP4, MOV, AVI, MPEG) by FFmpeg. Other files that a
// container names are not opened.
class VideoReader {
 public:
  // Throws std::runtime_error, one line with the file: no video, damaged at its start, of another
  // format.
  explicit VideoReader(const std::filesystem::path& file);
  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;

  // As the camera wrote it. Some write when a recording began, others when it ended.
  std::optional<UtcTime> CreationTime() const;

  // The next one in the order of presentation; none at the end. A damaged one is an error in its
  // place, in one line without the file.
  std::optional<tl::expected<VideoPicture, std::string>> Next();
  // The same without its picture. False at the end.
  bool Skip();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
