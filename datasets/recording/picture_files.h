// Writes the pictures of a recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "datasets/camera/camera_capture.h"
#include "datasets/sequence.h"

namespace pleinair {

// How pictures are stored.
enum class PictureStore {
  kRaw,   // A file a picture: as the driver gave it where that is MJPEG or Bayer, else PNG.
  kFfv1,  // Video, lossless: codes bit for bit. Not of Bayer.
  kH264,  // Video to look at: its codes are not the camera's. Not of Bayer.
};

// Writes pictures in one of these ways. One thread at a time.
class PictureFiles {
 public:
  virtual ~PictureFiles() = default;
  // Writes the picture, completely or not at all, and sets its place in `entry`. Returns its bytes
  // on disk; an error for one that cannot be decoded. Throws std::runtime_error where the disk
  // fails.
  virtual tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame,
                                                       FrameEntry& entry) = 0;
  // Closes the file that is open; a later picture starts another one. Throws std::runtime_error
  // where the disk fails: pictures written before can still be read.
  virtual void Finish() {}
};

// In `folder`, named for the UTC of the (first) picture: frames/20261123T005140.250000Z.jpg (.raw,
// .png), video/20261123T005140.250000Z.mkv, which hold 1800 pictures each. A second one of the same
// microsecond (clocks may be stepped back) has -2 in its name.
// Throws std::invalid_argument for a video of Bayer pictures.
std::unique_ptr<PictureFiles> MakePictureFiles(PictureStore store,
                                               const PictureLayout& layout,
                                               const std::filesystem::path& folder);

}  // namespace pleinair
