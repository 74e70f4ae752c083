#include "apps/viewer/view_source.h"

#include <chrono>
#include <stdexcept>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "datasets/camera/live_frame_source.h"
#include "datasets/picture_source.h"

namespace pleinair {
namespace {

// A camera's frames go on where sessions change.
class SharedFrames final : public FrameSource {
 public:
  explicit SharedFrames(FrameSource& frames) : frames_(frames) {}
  std::optional<tl::expected<Frame, FrameError>> Next() override { return frames_.Next(); }
  std::optional<int> Count() const override { return frames_.Count(); }

 private:
  FrameSource& frames_;
};

void RequireOfCamera(const SessionOptions& options) {
  if (options.source == SourceKind::kFisheye) {
    throw std::invalid_argument("source=fisheye: expected a recorded sequence, found a camera");
  }
  if (options.albedo == AlbedoSource::kSelfCalibrated) {
    throw std::invalid_argument(
        "albedo=self-calibrated: expected a recorded sequence, found a camera");
  }
}

}  // namespace

ViewSource::ViewSource(const ViewCommandOptions& options, EventLog& events)
    : options_(options), events_(events) {
  if (options.input.empty() || !IsCameraName(options.input)) return;
  site_ = ReadSite(options.sequence, std::chrono::system_clock::now());
  CameraRequest request = options.camera;
  if (!request.width_px) {
    request.width_px = site_->intrinsics.width_px;
    request.height_px = site_->intrinsics.height_px;
  }
  capture_.emplace(options.input, request, CaptureOptions{}, events);
  // A camera of another shape would fail in every frame.
  ScaledTo(site_->intrinsics, capture_->Layout().width_px, capture_->Layout().height_px);
}

ViewSource::~ViewSource() = default;

double ViewSource::FramesPerSecond() const { return capture_ ? capture_->FramesPerSecond() : 0.0; }

UtcTime ViewSource::Now() const {
  return capture_ ? capture_->Clock().Now() : std::chrono::system_clock::now();
}

void ViewSource::Stop() {
  if (capture_) capture_->Stop();
}

std::shared_ptr<const LoadedSequence> ViewSource::Load(const SessionOptions& options,
                                                       const Progress& progress) const {
  if (IsLive()) {
    RequireOfCamera(options);
    return LoadSite(options, capture_->Clock().Now(), progress);
  }
  if (options_.input.empty()) return LoadSequence(options, progress);
  return LoadSite(options, FirstPictureTime(options_.input, options_.times), progress);
}

std::unique_ptr<FrameSource> ViewSource::Frames(const Sequence& sequence,
                                                const SessionOptions& options) {
  if (IsLive()) {
    live_frames_ = MakeLiveFrameSource(
        sequence, *capture_, events_, options.camera_noise, [this](const CameraFrame& frame) {
          if (recorder_) recorder_->Offer(frame);
        });
    return std::make_unique<SharedFrames>(*live_frames_);
  }
  if (options_.input.empty()) return nullptr;
  return MakeFrameSourceAt(sequence, options_.input, options_.times, options.camera_noise);
}

void ViewSource::Record(bool is_recording) {
  if (!IsLive() || is_recording == recorder_.has_value()) return;
  if (!is_recording) {
    recorder_->Finish();
    recorder_.reset();
    return;
  }
  RecorderOptions options;
  options.recording.folder =
      options_.out /
      fmt::format("recording-{:%Y%m%d-%H%M%S}",
                  fmt::gmtime(std::chrono::system_clock::to_time_t(
                      std::chrono::time_point_cast<std::chrono::system_clock::duration>(Now()))));
  recorder_.emplace(*site_, capture_->Layout(), options, events_);
}

std::string ViewSource::WhyRecordingStopped() const {
  return recorder_ ? recorder_->Status().stopped : std::string();
}

void ViewSource::AddEvents(const std::vector<Event>& events) {
  if (recorder_) recorder_->AddEvents(events);
}

}  // namespace pleinair
