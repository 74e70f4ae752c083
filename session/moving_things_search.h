// Searches a recording for moving things.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/moving_things.h"
#include "relight/progress.h"
#include "scene/frame.h"
#include "session/session_options.h"

namespace pleinair {

// The result over a recording.
struct MovingThingsInSequence {
  MovingThingsFound found;
  int left_out = 0;          // Frames of another camera or pose, or without light.
  std::string why_left_out;  // Reason of the first of them.
  Frame shown;               // The first frame that was used.
};

// Estimates the light of at most `most_frames` frames, spread evenly over the recording of
// `options`, each without the others, and compares the frames with the model under it (see
// MovingThings). No frames are drawn.
// Throws  as LoadSequence; std::runtime_error where fewer than three frames of one camera pose have
//         light.
MovingThingsInSequence FindMovingThings(const SessionOptions& options,
                                        int most_frames,
                                        const MovingThingsOptions& moving = {},
                                        const Progress& progress = {});

}  // namespace pleinair
