#include "datasets/posed_frame_source.h"

#include <optional>
#include <utility>

#include "datasets/diffuse_mask.h"

namespace pleinair {
namespace {

class PosedFrameSource final : public FrameSource {
 public:
  PosedFrameSource(std::unique_ptr<FrameSource> frames, PoseAtTime pose_at, HeldPoseReport report)
      : frames_(std::move(frames)), pose_at_(std::move(pose_at)), report_(std::move(report)) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    auto frame = frames_->Next();
    if (!frame || !*frame) return frame;
    const auto pose = pose_at_((*frame)->time);
    if (!pose) {
      return tl::unexpected(
          FrameError{(*frame)->index, (*frame)->time, "camera pose is not known: " + pose.error()});
    }
    (*frame)->camera.camera_from_world = pose->camera_from_world;
    if (report_ && pose->held_s > 0.0) report_(**frame, pose->held_s);
    return frame;
  }

  std::optional<int> Count() const override { return frames_->Count(); }
  bool Seek(int index) override { return frames_->Seek(index); }

 private:
  std::unique_ptr<FrameSource> frames_;
  PoseAtTime pose_at_;
  HeldPoseReport report_;
};

class SteadyFrameSource final : public FrameSource {
 public:
  SteadyFrameSource(std::unique_ptr<FrameSource> frames, const PoseFilterOptions& options)
      : frames_(std::move(frames)), filter_(options) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    auto frame = frames_->Next();
    if (!frame || !*frame) return frame;
    Camera& camera = (*frame)->camera;
    camera.camera_from_world =
        filter_.Update(camera.intrinsics, {(*frame)->time, camera.camera_from_world}, state_);
    return frame;
  }

  std::optional<int> Count() const override { return frames_->Count(); }
  bool Seek(int index) override {
    state_ = {};
    return frames_->Seek(index);
  }

 private:
  std::unique_ptr<FrameSource> frames_;
  PoseFilter filter_;
  PoseFilterState state_;
};

}  // namespace

Sequence WithoutPoses(Sequence sequence) {
  sequence.camera_from_world = glm::dmat4(1.0);
  for (FrameEntry& frame : sequence.frames) frame.camera_from_world.reset();
  if (const auto mask = ReadDiffuseMask(sequence); mask && !mask->is_over_map) {
    sequence.diffuse_mask.reset();
  }
  return sequence;
}

std::unique_ptr<FrameSource> MakePosedFrameSource(std::unique_ptr<FrameSource> frames,
                                                  PoseAtTime pose_at,
                                                  HeldPoseReport report) {
  return std::make_unique<PosedFrameSource>(
      std::move(frames), std::move(pose_at), std::move(report));
}

std::unique_ptr<FrameSource> MakeSteadyFrameSource(std::unique_ptr<FrameSource> frames,
                                                   const PoseFilterOptions& options) {
  return std::make_unique<SteadyFrameSource>(std::move(frames), options);
}

}  // namespace pleinair
