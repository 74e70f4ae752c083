// Videos and pictures, taken by a camera at a site, as sources of frames.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/camera_noise.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"

namespace pleinair {

// Times of pictures, in addition to those in their files.
struct PictureTimes {
  // Time of the first picture; replaces that in the files.
  std::optional<UtcTime> start;
  // From a picture of a folder to the next, with `start`.
  std::optional<std::chrono::nanoseconds> interval;
  // For EXIF times without an offset: "Z", "+02:00".
  std::string utc_offset;

  // Throws std::invalid_argument naming the field.
  void Validate() const;
};

// Whether `input` is a folder, or a picture itself, and so no video.
bool IsPictureOrFolder(const std::filesystem::path& input);

// The pictures in a folder (PNG or JPEG, found by their content; no folders in it), by name; of a
// picture itself, that one. Throws std::runtime_error naming the folder: it has none.
std::vector<std::filesystem::path> PictureFilesIn(const std::filesystem::path& input);

// Frames of a video file's pictures, at the times of their presentation after `times.start`, or
// after the container's time of creation. Their exposure is unknown.
//
// `site` as ReadSite gives it; copied. A picture that is damaged, or of another shape than the
// site's camera's, is that frame's error. Throws std::runtime_error, one line with the file: no
// video, no time; as MakeRecordedFrameSource for the site's response and mask.
std::unique_ptr<FrameSource> MakeVideoFrameSource(const std::filesystem::path& file,
                                                  const Sequence& site,
                                                  const PictureTimes& times,
                                                  const CameraNoise& noise = {});

// Frames of the pictures that PictureFilesIn finds.
//
// Order    with `times.start` and `times.interval` that of their names, at these times; else that
//          of their EXIF times (DateTimeOriginal, SubSecTimeOriginal, OffsetTimeOriginal).
// Exposure as EXIF states it.
// Errors   as above; a picture without a time beside ones that have it is that frame's error.
std::unique_ptr<FrameSource> MakePictureFileSource(const std::filesystem::path& input,
                                                   const Sequence& site,
                                                   const PictureTimes& times,
                                                   const CameraNoise& noise = {});

// One of the two, by the kind of `input`.
std::unique_ptr<FrameSource> MakeFrameSourceAt(const Sequence& site,
                                               const std::filesystem::path& input,
                                               const PictureTimes& times,
                                               const CameraNoise& noise = {});

// The time of the first frame of such a source, for ReadSite. Throws as the source.
UtcTime FirstPictureTime(const std::filesystem::path& input, const PictureTimes& times);

}  // namespace pleinair
