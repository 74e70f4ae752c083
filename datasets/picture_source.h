// Videos and folders of pictures, taken by a camera at a site, as sources of frames.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "calib/camera_noise.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"

namespace pleinair {

// What is known of pictures' times beside what their files say.
struct PictureTimes {
  // Of the first picture, in place of what the files say.
  std::optional<UtcTime> start;
  // From a picture of a folder to the next, with `start`.
  std::optional<std::chrono::nanoseconds> interval;
  // Of EXIF times that state none: "Z", "+02:00".
  std::string utc_offset;

  // Throws std::invalid_argument naming the field.
  void Validate() const;
};

// Frames of a video file's pictures, at the times of their presentation after `times.start`, or
// after what the container states as its creation. Their exposure is unknown.
//
// `site` as ReadSite gives it; copied. A picture that is damaged, or of another shape than the
// site's camera's, is that frame's error. Throws std::runtime_error, one line with the file: no
// video, no time; as MakeRecordedFrameSource for the site's response and mask.
std::unique_ptr<FrameSource> MakeVideoFrameSource(const std::filesystem::path& file,
                                                  const Sequence& site,
                                                  const PictureTimes& times,
                                                  const CameraNoise& noise = {});

// Frames of the pictures in a folder (PNG or JPEG, found by their content; no folders in it).
//
// Order    with `times.start` and `times.interval` that of their names, at these times; else that
//          of their EXIF times (DateTimeOriginal, SubSecTimeOriginal, OffsetTimeOriginal).
// Exposure as EXIF states it.
// Errors   as above; a picture without a time beside ones that have it is that frame's error.
std::unique_ptr<FrameSource> MakePictureFolderSource(const std::filesystem::path& folder,
                                                     const Sequence& site,
                                                     const PictureTimes& times,
                                                     const CameraNoise& noise = {});

// One of the two: whatever `input` is.
std::unique_ptr<FrameSource> MakeFrameSourceAt(const Sequence& site,
                                               const std::filesystem::path& input,
                                               const PictureTimes& times,
                                               const CameraNoise& noise = {});

// The first frame's time of such a source, for ReadSite. Throws as it would.
UtcTime FirstPictureTime(const std::filesystem::path& input, const PictureTimes& times);

}  // namespace pleinair
