// Frames whose camera is where the markers in their pictures say.
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

// How one frame's pose was come by.
struct MarkerFrameReport {
  int index = 0;
  std::vector<int> markers;         // Ids of the board that the pose rests on.
  std::vector<int> left_out;        // Ids of the board, seen where they do not fit.
  std::optional<CameraPose> found;  // This frame's own pose, believed or not.
  std::optional<TrackedPose> used;
  std::string reason;  // Why the frame's own is none, or is not used.
};

struct MarkerFrameOptions {
  CameraPoseOptions pose;
  PoseTrackerOptions tracker;
  CameraNoise camera_noise;                                // Of a recorded sequence's 8-bit frames.
  std::function<void(const MarkerFrameReport&)> on_frame;  // May be empty.
};

// `frames` with the poses that the markers of `board` give, followed by PoseTracker's rules;
// whatever pose a frame came with is not looked at. Where none is known, that is the frame's error
// ("camera pose is not known: ..."); errors of `frames` go through, and count as frames without
// markers. Throws  as MarkerFrameOptions' parts when they are not valid.
std::unique_ptr<FrameSource> MakeMarkerFrameSource(std::unique_ptr<FrameSource> frames,
                                                   MarkerBoard board,
                                                   MarkerFrameOptions options = {});

// A recorded sequence as such a source. A diffuse_mask over the first frame says nothing of a
// camera that moves, and is not applied. Throws  as MakeRecordedFrameSource, too.
std::unique_ptr<FrameSource> MakeRecordedMarkerFrameSource(const Sequence& sequence,
                                                           FrameKind preferred,
                                                           const MarkerBoard& board,
                                                           MarkerFrameOptions options = {});

// `sequence` with one camera pose, that of the first frame whose markers give one: for what has to
// know roughly where the camera is before the first frame is played.
// Throws  std::runtime_error, with the first frame's reason, where no frame has one; as above.
Sequence WithFirstMarkerPose(Sequence sequence,
                             FrameKind preferred,
                             const MarkerBoard& board,
                             const MarkerFrameOptions& options = {});

}  // namespace pleinair
