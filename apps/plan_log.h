// Lines of plan.jsonl: what was simulated of a frame, what was left out, and why.
#pragma once

#include <string>

#include "pipeline/frame_pipeline.h"

namespace pleinair {

// One frame's. Times are in milliseconds, bounds in 8-bit code values at the frame's exposure.
std::string PlanLine(const Frame& frame, const FrameResult& result, const EffectSettings& settings);

}  // namespace pleinair
