#include "datasets/recording/picture_files.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "datasets/video/video_writer.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

constexpr int kPicturesAVideo = 1800;

// "frames/20261123T005140.250000Z" and `ending`, that no file has yet.
fs::path NameByTime(const fs::path& folder,
                    const fs::path& kind,
                    UtcTime time,
                    const std::string& ending) {
  const auto second = std::chrono::floor<std::chrono::seconds>(time);
  const auto fraction = std::chrono::floor<std::chrono::microseconds>(time - second);
  const std::string stem = fmt::format("{:%Y%m%dT%H%M%S}.{:06}Z", second, fraction.count());
  fs::path name = kind / (stem + ending);
  for (int again = 2; fs::exists(folder / name); ++again) {
    name = kind / fmt::format("{}-{}{}", stem, again, ending);
  }
  return name;
}

Gray8Image GreyOf(const Rgb8Image& picture) {
  Gray8Image grey(picture.width, picture.height);
  std::ranges::transform(
      picture.pixels, grey.pixels.begin(), [](const glm::u8vec3& code) { return code.r; });
  return grey;
}

class SinglePictureFiles final : public PictureFiles {
 public:
  explicit SinglePictureFiles(fs::path folder) : folder_(std::move(folder)) {
    fs::create_directories(folder_ / "frames");
  }

  tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame,
                                               FrameEntry& entry) override {
    const CapturedBuffer& buffer = frame.buffer;
    const auto name = [&](const char* ending) {
      return NameByTime(folder_, "frames", frame.time, ending);
    };
    switch (buffer.layout.format.coding) {
      case PixelCoding::kMjpeg:
        entry.image_ldr = name(".jpg");
        WriteWholeFile(folder_ / *entry.image_ldr, buffer.bytes);
        return buffer.bytes.size();
      case PixelCoding::kBayer:
        entry.raw =
            RawImageEntry{name(".raw"),
                          buffer.layout.format,
                          buffer.layout.stride_bytes,
                          buffer.development.value_or(UsualDevelopment(buffer.layout.format.bits))};
        WriteWholeFile(folder_ / entry.raw->image, buffer.bytes);
        return buffer.bytes.size();
      default:
        break;
    }
    const auto codes = DecodeCodes(buffer.bytes, buffer.layout);
    if (!codes) return tl::unexpected(codes.error());
    entry.image_ldr = name(".png");
    const fs::path file = folder_ / *entry.image_ldr;
    if (buffer.layout.format.coding == PixelCoding::kGrey) {
      WritePng(file, GreyOf(*codes));
    } else {
      WritePng(file, *codes);
    }
    return fs::file_size(file);
  }

 private:
  fs::path folder_;
};

class VideoFiles final : public PictureFiles {
 public:
  VideoFiles(VideoCodec codec, fs::path folder) : codec_(codec), folder_(std::move(folder)) {
    fs::create_directories(folder_ / "video");
  }

  tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame,
                                               FrameEntry& entry) override {
    const PictureLayout& layout = frame.buffer.layout;
    const auto codes = DecodeCodes(frame.buffer.bytes, layout);
    if (!codes) return tl::unexpected(codes.error());
    if (!writer_ || pictures_ == kPicturesAVideo) {
      Finish();
      file_ = NameByTime(folder_, "video", frame.time, ".mkv");
      writer_ =
          std::make_unique<VideoWriter>(folder_ / file_,
                                        VideoFormat{codec_,
                                                    layout.width_px,
                                                    layout.height_px,
                                                    layout.format.coding == PixelCoding::kGrey,
                                                    frame.time});
      pictures_ = 0;
      start_ = frame.buffer.monotonic_time;
    }
    const std::uint64_t bytes = Write(*codes, frame.buffer.monotonic_time - start_);
    entry.image_ldr = file_;
    entry.video_frame = pictures_++;
    return bytes;
  }

  void Finish() override {
    const std::unique_ptr<VideoWriter> last = std::move(writer_);
    if (last) last->Finish();
  }

 private:
  // A video that the disk has failed ends there.
  std::uint64_t Write(const Rgb8Image& codes, std::chrono::nanoseconds time) {
    try {
      return writer_->Add(codes, time);
    } catch (...) {
      writer_.reset();
      throw;
    }
  }

  VideoCodec codec_;
  fs::path folder_;
  std::unique_ptr<VideoWriter> writer_;
  fs::path file_;
  int pictures_ = 0;
  std::chrono::nanoseconds start_{0};
};

}  // namespace

std::unique_ptr<PictureFiles> MakePictureFiles(PictureStore store,
                                               const PictureLayout& layout,
                                               const fs::path& folder) {
  if (store == PictureStore::kRaw) return std::make_unique<SinglePictureFiles>(folder);
  if (layout.format.coding == PixelCoding::kBayer) {
    throw std::invalid_argument("recording: expected the store `raw` for " + NameOf(layout.format) +
                                ", found a video");
  }
  return std::make_unique<VideoFiles>(
      store == PictureStore::kFfv1 ? VideoCodec::kFfv1 : VideoCodec::kH264, folder);
}

}  // namespace pleinair
