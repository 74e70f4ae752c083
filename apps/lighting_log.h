// lighting.jsonl: one line a frame.
#pragma once

#include <string>

#include "datasets/frame_source.h"
#include "pipeline/frame_pipeline.h"

namespace pleinair {

// The line of a frame that was done, without the line's end.
std::string LightingLine(const Frame& frame, const FrameResult& result);

// The line of a frame that was not.
std::string FailureLine(const FrameError& error);

}  // namespace pleinair
