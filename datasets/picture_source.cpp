#include "datasets/picture_source.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "calib/exif_exposure.h"
#include "calib/exif_time.h"
#include "datasets/internal/held_camera.h"
#include "datasets/internal/site_frames.h"
#include "datasets/video/video_reader.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

UtcTime StartOf(const fs::path& file, const VideoReader& video, const PictureTimes& times) {
  if (times.start) return *times.start;
  if (const std::optional<UtcTime> created = video.CreationTime()) return *created;
  RefuseFile(file, "expected a creation time in the video, found none: --start-time gives it");
}

class VideoFrameSource final : public FrameSource {
 public:
  VideoFrameSource(const fs::path& file,
                   const Sequence& site,
                   const PictureTimes& times,
                   const CameraNoise& noise)
      : file_(file),
        site_(site, noise),
        video_(std::make_unique<VideoReader>(file)),
        start_(StartOf(file, *video_, times)) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    auto picture = video_->Next();
    if (!picture) return std::nullopt;
    const int index = next_++;
    const auto failed = [&](const std::string& why) {
      return tl::make_unexpected(FrameError{
          index, last_, file_.string() + ", picture " + std::to_string(index) + ": " + why});
    };
    if (!*picture) return failed(picture->error());
    FrameEntry taken;
    taken.time = last_ = start_ + (*picture)->time;
    try {
      return site_.Make(index, taken, std::move((*picture)->codes));
    } catch (const std::exception& error) {
      return failed(error.what());
    }
  }

  std::optional<int> Count() const override { return std::nullopt; }

  // Back: from the start of the file.
  bool Seek(int index) override {
    if (index < next_) {
      video_ = std::make_unique<VideoReader>(file_);
      next_ = 0;
    }
    while (next_ < index && video_->Skip()) ++next_;
    return true;
  }

 private:
  fs::path file_;
  SiteFrames site_;
  std::unique_ptr<VideoReader> video_;
  UtcTime start_{};
  UtcTime last_ = start_;
  int next_ = 0;
};

// A picture whose exposure is not read yet.
struct TimedPicture {
  fs::path file;
  UtcTime time{};
  std::string fault;  // Why it has no time; empty: it has.
};

bool IsPicture(const fs::path& file) {
  if (!fs::is_regular_file(file) || fs::file_size(file) == 0) return false;
  const std::string content = DescribeContent(file);
  return content.find("PNG") != std::string::npos || content.find("JPEG") != std::string::npos;
}

TimedPicture WithExifTime(const fs::path& file, const PictureTimes& times) {
  TimedPicture picture{file, {}, {}};
  const std::optional<ExifTime> exif = ReadExifTime(file);
  if (!exif) {
    picture.fault = "expected an EXIF time, found none: --start-time and --every give times";
    return picture;
  }
  const std::string& offset = exif->utc_offset.empty() ? times.utc_offset : exif->utc_offset;
  if (offset.empty()) {
    picture.fault = "expected a time zone in EXIF, found none: --time-zone gives it";
    return picture;
  }
  try {
    picture.time = ParseUtcTime(exif->local_time + offset);
  } catch (const std::invalid_argument& error) {
    picture.fault = std::string("EXIF ") + error.what();
  }
  return picture;
}

// In the order of their frames; at least one has a time.
std::vector<TimedPicture> PicturesIn(const fs::path& input, const PictureTimes& times) {
  times.Validate();
  std::vector<TimedPicture> pictures;
  for (const fs::path& file : PictureFilesIn(input)) {
    if (!times.start) {
      pictures.push_back(WithExifTime(file, times));
      // A picture without a time gets the time of the one before it, and so keeps its place.
      if (!pictures.back().fault.empty() && pictures.size() > 1) {
        pictures.back().time = pictures[pictures.size() - 2].time;
      }
      continue;
    }
    const auto index = static_cast<std::int64_t>(pictures.size());
    pictures.push_back(
        {file, *times.start + index * times.interval.value_or(std::chrono::nanoseconds{0}), {}});
  }
  if (times.start && !times.interval && pictures.size() > 1) {
    RefuseFile(input, "expected --every with --start-time, for more than one picture");
  }
  const auto has_time = [](const TimedPicture& picture) { return picture.fault.empty(); };
  const auto first = std::ranges::find_if(pictures, has_time);
  if (first == pictures.end()) RefuseFile(pictures.front().file, pictures.front().fault);
  for (auto before = pictures.begin(); before != first; ++before) before->time = first->time;
  std::ranges::stable_sort(pictures, {}, &TimedPicture::time);
  return pictures;
}

class PictureFileSource final : public FrameSource {
 public:
  PictureFileSource(const fs::path& input,
                    const Sequence& site,
                    const PictureTimes& times,
                    const CameraNoise& noise)
      : site_(site, noise), pictures_(PicturesIn(input, times)) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    if (next_ == pictures_.size()) return std::nullopt;
    const auto index = static_cast<int>(next_);
    const TimedPicture& picture = pictures_[next_++];
    try {
      return Read(index, picture);
    } catch (const std::exception& error) {
      return tl::make_unexpected(FrameError{index, picture.time, error.what()});
    }
  }

  std::optional<int> Count() const override { return static_cast<int>(pictures_.size()); }

  bool Seek(int index) override {
    next_ = static_cast<std::size_t>(index);
    return true;
  }

 private:
  Frame Read(int index, const TimedPicture& picture) const {
    if (!picture.fault.empty()) RefuseFile(picture.file, picture.fault);
    FrameEntry taken;
    taken.time = picture.time;
    const ExifExposure exposure = ReadExifExposure(picture.file);
    taken.exposure_s = exposure.exposure_s;
    taken.iso = exposure.iso;
    taken.f_number = exposure.f_number;
    Rgb8Image codes = ReadDisplayImage(picture.file);
    try {
      RequireHeldAs(site_.Site().CameraOfFrame(0), picture.file);
      return site_.Make(index, taken, std::move(codes));
    } catch (const std::exception& error) {
      RefuseFile(picture.file, error.what());
    }
  }

  SiteFrames site_;
  std::vector<TimedPicture> pictures_;
  std::size_t next_ = 0;
};

}  // namespace

bool IsPictureOrFolder(const fs::path& input) {
  return fs::is_directory(input) || IsPicture(input);
}

std::vector<fs::path> PictureFilesIn(const fs::path& input) {
  if (IsPicture(input)) return {input};
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(input)) {
    const bool is_hidden = entry.path().filename().string().starts_with(".");
    if (!is_hidden && IsPicture(entry.path())) files.push_back(entry.path());
  }
  if (files.empty()) RefuseFile(input, "expected PNG or JPEG pictures, found none");
  std::ranges::sort(files);
  return files;
}

void PictureTimes::Validate() const {
  if (interval && interval->count() <= 0) {
    throw std::invalid_argument("pictures' interval: expected a time above 0");
  }
  if (interval && !start) {
    throw std::invalid_argument("pictures' interval: expected --start-time with --every");
  }
  if (utc_offset.empty()) return;
  try {
    ParseUtcTime("2000-01-01T00:00:00" + utc_offset);
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("time zone '" + utc_offset + "': expected Z, or such as +02:00");
  }
}

std::unique_ptr<FrameSource> MakeVideoFrameSource(const fs::path& file,
                                                  const Sequence& site,
                                                  const PictureTimes& times,
                                                  const CameraNoise& noise) {
  return std::make_unique<VideoFrameSource>(file, site, times, noise);
}

std::unique_ptr<FrameSource> MakePictureFileSource(const fs::path& input,
                                                   const Sequence& site,
                                                   const PictureTimes& times,
                                                   const CameraNoise& noise) {
  return std::make_unique<PictureFileSource>(input, site, times, noise);
}

std::unique_ptr<FrameSource> MakeFrameSourceAt(const Sequence& site,
                                               const fs::path& input,
                                               const PictureTimes& times,
                                               const CameraNoise& noise) {
  if (IsPictureOrFolder(input)) return MakePictureFileSource(input, site, times, noise);
  return MakeVideoFrameSource(input, site, times, noise);
}

UtcTime FirstPictureTime(const fs::path& input, const PictureTimes& times) {
  if (IsPictureOrFolder(input)) return PicturesIn(input, times).front().time;
  return StartOf(input, VideoReader(input), times);
}

}  // namespace pleinair
