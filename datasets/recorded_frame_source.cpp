// Plays a recorded sequence, one file a frame.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "calib/response.h"
#include "datasets/fisheye_setup.h"
#include "datasets/frame_source.h"
#include "datasets/internal/held_camera.h"
#include "datasets/internal/sampling_mask.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/picture_frame.h"
#include "datasets/video/video_reader.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// Light in denormal numbers has no accurate shares: the file has wrong units.
void RequireNormalLight(const RgbImage& radiance, const std::filesystem::path& file) {
  constexpr float kLeastLight = 1e-30f;
  float brightest = 0.0f;
  for (const glm::vec3& pixel : radiance.pixels) {
    brightest = std::max({brightest, pixel.x, pixel.y, pixel.z});
  }
  if (!(brightest > 0.0f) || brightest >= kLeastLight) return;
  std::ostringstream text;
  text << file.string() << ": expected a brightest pixel of " << kLeastLight
       << " or more, found one of " << brightest;
  throw std::runtime_error(text.str());
}

// A frame's picture under the other's key is the likeliest slip: the refusal names the right one.
void RequireKindOfFrame(const std::filesystem::path& file, FrameKind kind) {
  const bool is_linear = HoldsRadiance(file);
  if (is_linear == (kind == FrameKind::kLinear)) return;
  throw std::runtime_error(file.string() +
                           (is_linear ? ": expected a PNG or JPEG picture under `image_ldr`, found "
                                      : ": expected an OpenEXR or Radiance HDR picture under "
                                        "`image` (8-bit ones go under `image_ldr`), found ") +
                           DescribeContent(file));
}

void RequireHeld(const Camera& camera, const std::filesystem::path& file) {
  try {
    RequireHeldAs(camera, file);
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

void RequireFinite(const RgbImage& radiance,
                   const ImageDefects& defects,
                   const std::filesystem::path& file) {
  if (HasFinitePixel(radiance, defects)) return;
  throw std::runtime_error(file.string() + ": expected finite radiances, found none");
}

// Pictures of videos, which are fast to read in order.
class VideoPictures {
 public:
  // Throws std::runtime_error, one line with the file.
  Rgb8Image Read(const std::filesystem::path& file, int picture) {
    if (file != file_ || picture < next_) {
      file_.clear();
      reader_.emplace(file);
      file_ = file;
      next_ = 0;
    }
    while (next_ < picture && reader_->Skip()) ++next_;
    auto found = next_ == picture ? reader_->Next() : std::nullopt;
    const std::string name = file.string() + ", picture " + std::to_string(picture) + ": ";
    if (!found) {
      throw std::runtime_error(name + "expected it in the video, which ends after " +
                               std::to_string(next_));
    }
    ++next_;
    if (!*found) throw std::runtime_error(name + found->error());
    return std::move((*found)->codes);
  }

 private:
  std::filesystem::path file_;
  std::optional<VideoReader> reader_;
  int next_ = 0;
};

class RecordedFrameSource final : public FrameSource {
 public:
  RecordedFrameSource(const Sequence& sequence, FrameKind preferred, const CameraNoise& noise)
      : sequence_(sequence),
        preferred_(preferred),
        response_(ResponseOf(sequence)),
        noise_(std::make_shared<SignalNoise>(response_, noise)),
        mask_(sequence_) {
    if (HasFisheyePictures(sequence)) {
      fisheye_ = MakeFisheyeSetup(sequence.fisheye.value(), sequence.folder);
    }
  }

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    if (next_ >= sequence_.frames.size()) return std::nullopt;
    const std::size_t index = next_++;
    try {
      return Read(index);
    } catch (const std::exception& error) {
      return tl::make_unexpected(
          FrameError{static_cast<int>(index), sequence_.frames[index].time, error.what()});
    }
  }

  std::optional<int> Count() const override { return static_cast<int>(sequence_.frames.size()); }

  bool Seek(int index) override {
    next_ = static_cast<std::size_t>(index);
    return true;
  }

 private:
  // Checked again at each read: a link may have been put there since the sequence was read.
  std::filesystem::path FileOf(const std::filesystem::path& relative) const {
    return FileInside(sequence_.folder, relative);
  }

  Frame Read(std::size_t index) {
    const FrameEntry& entry = sequence_.frames[index];
    Frame frame;
    frame.index = static_cast<int>(index);
    frame.time = entry.time;
    frame.camera = sequence_.CameraOfFrame(index);
    frame.sun_direction_enu = sequence_.StatedSunDirectionEnu(index);
    frame.weather = sequence_.WeatherOfFrame(index);
    frame.exposure = entry.EffectiveExposure();
    frame.exposure_s = entry.exposure_s;
    frame.sample_polygons = entry.sample_polygons;
    const bool linear = IsPlayedLinear(entry, preferred_);
    if (entry.raw) {
      ReadRaw(FileOf(entry.raw->image), *entry.raw, frame);
    } else if (linear) {
      ReadLinear(FileOf(*entry.image), frame);
    } else {
      ReadCodes(FileOf(*entry.image_ldr), entry.video_frame, frame);
    }
    if (!linear && !entry.exposure) {
      frame.units = frame.exposure ? LightUnits::kRelative : LightUnits::kRelativePerFrame;
    }
    mask_.ApplyTo(frame);
    if (entry.fisheye) frame.fisheye_radiance = ReadFisheye(FileOf(*entry.fisheye));
    return frame;
  }

  static void ReadLinear(const std::filesystem::path& file, Frame& frame) {
    RequireKindOfFrame(file, FrameKind::kLinear);
    RgbImage radiance = ReadRadianceImage(file);
    RequireCameraSize(radiance, frame.camera.intrinsics, "camera", file);
    SetRadiance(std::move(radiance), frame);
    RequireFinite(frame.radiance, frame.defects, file);
  }

  static void ReadRaw(const std::filesystem::path& file, const RawImageEntry& raw, Frame& frame) {
    const CameraIntrinsics& camera = frame.camera.intrinsics;
    const PictureLayout layout = {
        raw.format, camera.width_px, camera.height_px, raw.stride_bytes, {}};
    auto picture = Develop(ReadWholeFile(file), layout, raw.development);
    if (!picture) throw std::runtime_error(file.string() + ": " + picture.error());
    SetDeveloped(std::move(*picture), frame);
  }

  void ReadCodes(const std::filesystem::path& file, std::optional<int> video_frame, Frame& frame) {
    if (!video_frame) RequireKindOfFrame(file, FrameKind::kLdr);
    if (!video_frame) RequireHeld(frame.camera, file);
    Rgb8Image codes = video_frame ? video_.Read(file, *video_frame) : ReadDisplayImage(file);
    RequireCameraSize(codes, frame.camera.intrinsics, "camera", file);
    SetCodes(std::move(codes), response_, noise_, frame);
  }

  RgbImage ReadFisheye(const std::filesystem::path& file) const {
    RgbImage radiance = ReadRadianceImage(file);
    RequireCameraSize(radiance, fisheye_.value().camera.intrinsics, "fisheye", file);
    RequireFinite(radiance, DefectsOf(radiance), file);
    RequireNormalLight(radiance, file);
    if (!fisheye_->room_from_fisheye_rgb) return radiance;
    const glm::mat3 room_from_fisheye(*fisheye_->room_from_fisheye_rgb);
    for (glm::vec3& pixel : radiance.pixels) {
      // An infinite sun stays infinite: times the matrix's zeros it would be no number.
      const bool is_infinite = std::isinf(pixel.x + pixel.y + pixel.z);
      pixel = is_infinite ? glm::vec3(pixel.x + pixel.y + pixel.z) : room_from_fisheye * pixel;
    }
    return radiance;
  }

  Sequence sequence_;
  FrameKind preferred_;
  ResponseCurve response_;
  std::shared_ptr<const SignalNoise> noise_;
  SamplingMask mask_;
  std::optional<FisheyeSetup> fisheye_;
  VideoPictures video_;
  std::size_t next_ = 0;
};

}  // namespace

ResponseCurve ResponseOf(const Sequence& sequence) {
  return sequence.response_ldr == "srgb8"
             ? ResponseCurve::Srgb()
             : ResponseCurve::FromFile(FileInside(sequence.folder, sequence.response_ldr));
}

bool IsPlayedLinear(const FrameEntry& entry, FrameKind preferred) {
  if (entry.raw) return false;
  return preferred == FrameKind::kLinear ? entry.image.has_value() : !entry.image_ldr.has_value();
}

std::unique_ptr<FrameSource> MakeRecordedFrameSource(const Sequence& sequence,
                                                     FrameKind preferred,
                                                     const CameraNoise& noise) {
  return std::make_unique<RecordedFrameSource>(sequence, preferred, noise);
}

}  // namespace pleinair
