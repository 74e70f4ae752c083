#include "apps/viewer/view_source.h"

#include <chrono>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "apps/input_refusals.h"
#include "datasets/camera/live_frame_source.h"
#include "datasets/picture_source.h"
#include "datasets/pose_lines.h"

namespace pleinair {
namespace {

// A camera's frames, which the recorder passes over, too. They stay with their session where the
// next one cannot be made.
class SharedFrames final : public FrameSource {
 public:
  explicit SharedFrames(std::shared_ptr<FrameSource> frames) : frames_(std::move(frames)) {}
  std::optional<tl::expected<Frame, FrameError>> Next() override { return frames_->Next(); }
  std::optional<int> Count() const override { return frames_->Count(); }

 private:
  std::shared_ptr<FrameSource> frames_;
};

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
  camera_.emplace(options, *capture_, events);
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
  if (camera_) camera_->Stop();
}

std::shared_ptr<const LoadedSequence> ViewSource::Load(const SessionOptions& options,
                                                       const Progress& progress) {
  RefuseOtherInputs({options_.input, options_.camera, options_.times}, options);
  if (IsLive()) {
    return LoadSite(PosedCamera::OfflineOptions(options), capture_->Clock().Now(), progress);
  }
  if (!poses_ && !options.poses.empty()) poses_ = ReadPoses(options.poses);
  if (options_.input.empty()) return LoadSequence(options, progress, poses_);
  return LoadSite(options, FirstPictureTime(options_.input, options_.times), progress, poses_);
}

std::unique_ptr<FrameSource> ViewSource::Frames(const LoadedSequence& loaded,
                                                const SessionOptions& options) {
  if (IsLive()) {
    PosedCamera::Taps taps;
    taps.record = [this](CameraFrame frame) {
      if (recorder_) recorder_->Offer(std::move(frame));
    };
    live_frames_ = camera_->FramesAt(loaded, options, taps);
    return std::make_unique<SharedFrames>(live_frames_);
  }
  if (options_.input.empty()) return nullptr;
  return PosedFramesAt(
      loaded, options_.input, options_.times, options, [this](const std::string& note) {
        events_.Add({Now(), EventKind::kPose, note});
      });
}

SessionOptions ViewSource::OptionsOfSession(const SessionOptions& options) const {
  return camera_ ? camera_->OptionsOfSession(options) : options;
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
