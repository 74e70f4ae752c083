// Frames whose camera is where something beside the sequence says.
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

// `sequence` for frames whose poses come from elsewhere: without its own, which may be absent. A
// diffuse_mask over the first frame says nothing of a camera that moves, and is left out.
Sequence WithoutPoses(Sequence sequence);

using PoseAtTime = std::function<tl::expected<TrackPose, std::string>(UtcTime)>;
// Of a frame whose pose was held: PoseTrackOptions::hold_s.
using HeldPoseReport = std::function<void(const Frame&, double held_s)>;

// `frames` with the camera where `pose_at` says at each frame's time, whatever pose a frame came
// with. Where it says none, that is the frame's error ("camera pose is not known: ..."). `report`
// may be empty.
std::unique_ptr<FrameSource> MakePosedFrameSource(std::unique_ptr<FrameSource> frames,
                                                  PoseAtTime pose_at,
                                                  HeldPoseReport report = {});

// `frames` with poses steadied by PoseFilter. Throws as PoseFilterOptions::Validate.
std::unique_ptr<FrameSource> MakeSteadyFrameSource(std::unique_ptr<FrameSource> frames,
                                                   const PoseFilterOptions& options = {});

}  // namespace pleinair
