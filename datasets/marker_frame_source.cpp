#include "datasets/marker_frame_source.h"

#include <stdexcept>
#include <utility>

#include "datasets/posed_frame_source.h"

namespace pleinair {
namespace {

class MarkerFrameSource final : public FrameSource {
 public:
  MarkerFrameSource(std::unique_ptr<FrameSource> frames,
                    MarkerBoard board,
                    MarkerFrameOptions options)
      : frames_(std::move(frames)),
        board_(std::move(board)),
        options_(std::move(options)),
        tracker_(options_.tracker) {
    options_.pose.Validate();
  }

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    auto frame = frames_->Next();
    if (!frame) return frame;
    MarkerFrameReport report;
    if (!*frame) {
      report.index = frame->error().index;
      report.reason = frame->error().reason;
      // The camera may have moved on meanwhile.
      static_cast<void>(tracker_.Update(frame->error().time, std::nullopt, report.reason));
    } else {
      Follow(**frame, report);
      if (!report.used) {
        frame = tl::unexpected(FrameError{(*frame)->index, (*frame)->time, report.reason});
      }
    }
    if (options_.on_frame) options_.on_frame(report);
    return frame;
  }

  std::optional<int> Count() const override { return frames_->Count(); }
  bool Seek(int index) override {
    tracker_ = PoseTracker(options_.tracker);
    return frames_->Seek(index);
  }

 private:
  void Follow(Frame& frame, MarkerFrameReport& report) {
    report.index = frame.index;
    const Gray8Image picture =
        frame.codes ? MarkerPicture(*frame.codes) : MarkerPicture(frame.radiance);
    const auto found = FindBoardPose(Lens(frame.camera.intrinsics),
                                     board_,
                                     DetectMarkers(picture, board_.dictionary),
                                     options_.pose,
                                     tracker_.Expected(frame.time));
    std::optional<glm::dmat4> camera_from_world;
    if (found) {
      report.markers = found->markers;
      report.left_out = found->left_out;
      report.found = found->pose;
      camera_from_world = found->pose.camera_from_world;
    } else {
      report.reason = found.error().reason;
    }
    const auto tracked = tracker_.Update(frame.time, camera_from_world, report.reason);
    if (!tracked) {
      report.reason = tracked.error();
      return;
    }
    if (found && tracked->origin == PoseOrigin::kCarried) {
      report.reason = "its own pose is a jump that no next frame has confirmed";
    }
    report.used = *tracked;
    frame.camera.camera_from_world = tracked->camera_from_world;
  }

  std::unique_ptr<FrameSource> frames_;
  MarkerBoard board_;
  MarkerFrameOptions options_;
  PoseTracker tracker_;
};

}  // namespace

std::unique_ptr<FrameSource> MakeMarkerFrameSource(std::unique_ptr<FrameSource> frames,
                                                   MarkerBoard board,
                                                   MarkerFrameOptions options) {
  return std::make_unique<MarkerFrameSource>(
      std::move(frames), std::move(board), std::move(options));
}

std::unique_ptr<FrameSource> MakeRecordedMarkerFrameSource(const Sequence& sequence,
                                                           FrameKind preferred,
                                                           const MarkerBoard& board,
                                                           MarkerFrameOptions options) {
  auto frames = MakeRecordedFrameSource(WithoutPoses(sequence), preferred, options.camera_noise);
  return MakeMarkerFrameSource(std::move(frames), board, std::move(options));
}

Sequence WithFirstMarkerPose(Sequence sequence,
                             FrameKind preferred,
                             const MarkerBoard& board,
                             const MarkerFrameOptions& options) {
  MarkerFrameOptions quiet = options;
  quiet.on_frame = nullptr;
  const auto frames = MakeRecordedMarkerFrameSource(sequence, preferred, board, std::move(quiet));
  std::string first_reason;
  while (const auto frame = frames->Next()) {
    if (*frame) {
      sequence.camera_from_world = (*frame)->camera.camera_from_world;
      for (FrameEntry& entry : sequence.frames) entry.camera_from_world.reset();
      return sequence;
    }
    if (first_reason.empty()) {
      first_reason =
          "; frame " + std::to_string(frame->error().index) + ": " + frame->error().reason;
    }
  }
  throw std::runtime_error(sequence.file.string() +
                           ": expected a frame that shows enough of the markers" + first_reason);
}

}  // namespace pleinair
