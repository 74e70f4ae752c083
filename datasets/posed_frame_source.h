// Frames with the camera's pose from a source outside the sequence.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "calib/pose_filter.h"
#include "calib/pose_track.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "scene/utc_time.h"

namespace pleinair {

// Returns `sequence` for frames with poses from elsewhere: without its own, which may be absent. A
// diffuse_mask over the first frame does not hold for a camera that moves, and is left out.
Sequence WithoutPoses(Sequence sequence);

using PoseAtTime = std::function<tl::expected<TrackPose, std::string>(UtcTime)>;
// For a frame whose pose was held: PoseTrackOptions::hold_s.
using HeldPoseReport = std::function<void(const Frame&, double held_s)>;

// Returns `frames` with the poses of `pose_at` at each frame's time, instead of their own. Where
// there is none, that is the frame's error ("camera pose is not known: ..."). `report` may be
// empty.
std::unique_ptr<FrameSource> MakePosedFrameSource(std::unique_ptr<FrameSource> frames,
                                                  PoseAtTime pose_at,
                                                  HeldPoseReport report = {});

// Returns `frames` with poses filtered by PoseFilter. Throws as PoseFilterOptions::Validate.
std::unique_ptr<FrameSource> MakeSteadyFrameSource(std::unique_ptr<FrameSource> frames,
                                                   const PoseFilterOptions& options = {});

}  // namespace pleinair
