// Where a recording puts its pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "datasets/camera/camera_capture.h"
#include "datasets/sequence.h"

namespace pleinair {

class PictureFiles {
 public:
  virtual ~PictureFiles() = default;
  // Writes the picture, completely or not at all, and says in `entry` where it is. Returns its
  // bytes on disk; an error for one that cannot be decoded. Throws std::runtime_error where the
  // disk fails.
  virtual tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame,
                                                       FrameEntry& entry) = 0;
};

// A file a picture in `folder`/frames, named for its UTC: 20261123T005140.250000Z.jpg. A second one
// of the same microsecond (clocks are stepped back) has -2 behind it. MJPEG and Bayer as the driver
// gave them (.jpg, .raw), other codes as PNG.
std::unique_ptr<PictureFiles> MakeSinglePictureFiles(const std::filesystem::path& folder);

// "frames/20261123T005140.250000Z" and `ending`, that no file has yet.
std::filesystem::path NameByTime(const std::filesystem::path& folder,
                                 const std::filesystem::path& kind,
                                 UtcTime time,
                                 const std::string& ending);

}  // namespace pleinair
