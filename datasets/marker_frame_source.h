// Frames with the camera's pose from the markers in their pictures.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/camera_pose.h"
#include "calib/marker_board.h"
#include "calib/pose_tracker.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"

namespace pleinair {

// How one frame's pose was found.
struct MarkerFrameReport {
  int index = 0;
  std::vector<int> markers;         // Ids of the board that the pose is from.
  std::vector<int> left_out;        // Ids of the board that were seen but do not fit.
  std::optional<CameraPose> found;  // This frame's own pose, accepted or not.
  std::optional<TrackedPose> used;
  std::string reason;  // Why the frame's own is none, or is not used.
};

// Set-up of the source.
struct MarkerFrameOptions {
  CameraPoseOptions pose;
  PoseTrackerOptions tracker;
  CameraNoise camera_noise;  // For a recorded sequence's 8-bit frames.
  std::function<void(const MarkerFrameReport&)> on_frame;  // May be empty.
};

// Returns `frames` with poses from the markers of `board`, tracked by PoseTracker; the frames' own
// poses are ignored. Where none is known, that is the frame's error ("camera pose is not known:
// ..."). Errors of `frames` are passed on, and count as frames without markers. Throws as
// MarkerFrameOptions' parts when they are not valid.
std::unique_ptr<FrameSource> MakeMarkerFrameSource(std::unique_ptr<FrameSource> frames,
                                                   MarkerBoard board,
                                                   MarkerFrameOptions options = {});

// A recorded sequence as such a source. A diffuse_mask over the first frame does not hold for a
// camera that moves, and is not applied. Throws as MakeRecordedFrameSource, too.
std::unique_ptr<FrameSource> MakeRecordedMarkerFrameSource(const Sequence& sequence,
                                                           FrameKind preferred,
                                                           const MarkerBoard& board,
                                                           MarkerFrameOptions options = {});

// Returns `sequence` with one camera pose: that of the first frame whose markers give one. For
// preparation, which needs the camera's rough place before the first frame is played.
// Throws  std::runtime_error, with the first frame's reason, where no frame has one; as above.
Sequence WithFirstMarkerPose(Sequence sequence,
                             FrameKind preferred,
                             const MarkerBoard& board,
                             const MarkerFrameOptions& options = {});

}  // namespace pleinair
