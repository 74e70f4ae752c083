// An MP4 of the frames that `run` made.
#pragma once

#include <filesystem>
#include <optional>

#include "datasets/video/video_writer.h"
#include "scene/image.h"

namespace pleinair {

// Written beside its final name and moved there by Finish when complete; otherwise nothing is left.
class VideoFile {
 public:
  // `frames_per_second` > 0, the speed at which it is shown. An older file stays until Finish.
  VideoFile(std::filesystem::path path, double frames_per_second);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  // All pictures have the first one's size; sides of an odd number of pixels get one more, as video
  // has to be even. Throws std::runtime_error naming the file: no encoder, a picture of another
  // size, a folder or disk that cannot be written (the file beside is named then).
  void Add(const Rgb8Image& picture);
  // Writes nothing where nothing was added, or Add failed. Throws std::runtime_error where the disk
  // fails, or it can't be moved.
  void Finish();

 private:
  std::filesystem::path path_;
  std::filesystem::path partial_;
  double frames_per_second_;
  std::optional<VideoWriter> writer_;
  int width_px_ = 0;  // Size of the pictures.
  int height_px_ = 0;
  int count_ = 0;
  bool is_whole_ = false;  // There are pictures, and all were written.
};

}  // namespace pleinair
