// Writes pictures to a video file.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "scene/image.h"
#include "scene/utc_time.h"

namespace pleinair {

// How pictures are coded.
enum class VideoCodec {
  kFfv1,  // Lossless: VideoReader returns the codes bit for bit.
  kH264,  // To look at: colours at half the resolution, and rounded.
};

// What a video is kept in.
enum class VideoContainer {
  kMatroska,  // Every added picture can be read, however the process ends.
  kMp4,       // Plays everywhere; can be read when the writer has ended.
};

// Set-up of a video.
struct VideoFormat {
  VideoCodec codec = VideoCodec::kFfv1;
  int width_px = 0;
  int height_px = 0;
  bool is_grey = false;  // Pictures have three equal channels, and are kept as one.
  // UTC of the first picture: VideoReader's CreationTime, in milliseconds. The default: not stated.
  UtcTime start{};
  VideoContainer container = VideoContainer::kMatroska;
  double frames_per_second = 0.0;  // For MP4, above 0; Matroska states each picture's time.
};

// One file.
class VideoWriter {
 public:
  // Throws std::runtime_error naming the file: it exists, cannot be made, or there is no such
  // encoder.
  VideoWriter(const std::filesystem::path& file, const VideoFormat& format);
  // Ends the file with its length and index; players jump in it then.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  // `time` counts from the first picture, in whole milliseconds (MP4: 1/120000 s): a time that does
  // not ascend by one is moved. Returns the bytes that the file has grown by. Throws
  // std::runtime_error naming the file where the disk fails: the file then ends before the picture,
  // and accepts no more. Throws std::invalid_argument for another size.
  std::uint64_t Add(const Rgb8Image& picture, std::chrono::nanoseconds time);

  // What the destructor does, where it matters whether it went well; nothing can be added then.
  // Throws std::runtime_error naming the file: the disk failed, now or in Add.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
