#include "session/site_frames.h"

#include <utility>

#include "datasets/posed_frame_source.h"

namespace pleinair {
namespace {

// Frames with their poses, and what is to be done with each: its picture came before its pose.
class TappedFrames final : public FrameSource {
 public:
  TappedFrames(std::unique_ptr<FrameSource> frames, std::function<void(const Frame&)> tap)
      : frames_(std::move(frames)), tap_(std::move(tap)) {}
  std::optional<tl::expected<Frame, FrameError>> Next() override {
    auto frame = frames_->Next();
    if (frame && *frame) tap_(**frame);
    return frame;
  }
  std::optional<int> Count() const override { return frames_->Count(); }

 private:
  std::unique_ptr<FrameSource> frames_;
  std::function<void(const Frame&)> tap_;
};

}  // namespace

std::filesystem::path PoseFileOf(const std::filesystem::path& poses) {
  return poses == "-" ? "/dev/stdin" : poses;
}

std::unique_ptr<FrameSource> PosedFramesAt(const LoadedSequence& loaded,
                                           const std::string& input,
                                           const PictureTimes& times,
                                           const SessionOptions& options,
                                           const PoseNote& note) {
  const bool moves = loaded.board || loaded.poses;
  return WithPoses(MakeFrameSourceAt(moves ? WithoutPoses(loaded.sequence) : loaded.sequence,
                                     input,
                                     times,
                                     options.camera_noise),
                   options,
                   loaded,
                   note);
}

PosedCamera::PosedCamera(const SessionOptions& options, CameraCapture& capture, EventLog& events)
    : capture_(capture),
      events_(events),
      moves_(!options.markers.empty() || !options.poses.empty()) {
  if (options.poses.empty()) return;
  poses_.emplace(
      options.poses.string(), PoseStreamOptions{options.pose_track, options.pose_wait_s}, events);
}

SessionOptions PosedCamera::OfflineOptions(SessionOptions options) {
  options.poses.clear();
  return options;
}

SessionOptions PosedCamera::OptionsOfSession(SessionOptions options) const {
  options.camera_moves = moves_;
  return options;
}

// A camera that moves is recorded with the poses that were used; frames without one are not.
std::unique_ptr<FrameSource> PosedCamera::FramesAt(const LoadedSequence& loaded,
                                                   const SessionOptions& options,
                                                   const Taps& taps) {
  auto frames = MakeLiveFrameSource(moves_ ? WithoutPoses(loaded.sequence) : loaded.sequence,
                                    capture_,
                                    events_,
                                    options.camera_noise,
                                    [this, taps](const CameraFrame& frame) {
                                      if (taps.taken) taps.taken(frame);
                                      if (!taps.record) return;
                                      if (moves_) {
                                        last_picture_ = frame;
                                      } else {
                                        taps.record(frame);
                                      }
                                    });
  PoseAtTime live;
  if (poses_) live = [this](UtcTime time) { return poses_->At(time); };
  frames = WithPoses(
      std::move(frames),
      options,
      loaded,
      [this](const std::string& note) {
        events_.Add({capture_.Clock().Now(), EventKind::kPose, note});
      },
      std::move(live));
  if (!moves_ || !taps.record) return frames;
  return std::make_unique<TappedFrames>(
      std::move(frames), [this, record = taps.record](const Frame& frame) {
        last_picture_.camera_from_world = frame.camera.camera_from_world;
        record(std::move(last_picture_));
      });
}

void PosedCamera::Stop() {
  if (poses_) poses_->Stop();
}

}  // namespace pleinair
