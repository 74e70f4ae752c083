// Frames from a live camera at a site.
#pragma once

#include <functional>
#include <memory>

#include "calib/camera_noise.h"
#include "datasets/camera/camera_capture.h"
#include "datasets/event.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"

namespace pleinair {

// Returns `site` for a picture of `width_px` x `height_px`: the same lens and sensor at another
// resolution. Throws std::runtime_error, one line, where the picture's aspect ratio differs by more
// than half a per cent.
CameraIntrinsics ScaledTo(const CameraIntrinsics& site, int width_px, int height_px);

// Called with every picture that becomes a frame, before it is decoded: for a recorder.
using CameraFrameTap = std::function<void(const CameraFrame&)>;

// Frames of `capture`, counted from 0, at `site` (as ReadSite gives it). 8-bit pictures are frames
// of code values, raw ones are linear.
//
// Units          relative where the camera states its exposure time (`exposure` is then t ISO / N^2
//                with ISO 100 and N 1 at gain 1), relative per frame otherwise.
// Damage         a picture that cannot be decoded is that frame's error, and an event.
// Ends           when the stream does. Next waits for a picture.
// Keeps          references to `capture` and `events`.
// Throws         as MakeRecordedFrameSource, for the site's response and mask.
std::unique_ptr<FrameSource> MakeLiveFrameSource(const Sequence& site,
                                                 CameraCapture& capture,
                                                 EventLog& events,
                                                 const CameraNoise& noise = {},
                                                 CameraFrameTap tap = {});

}  // namespace pleinair
