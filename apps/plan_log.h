// Lines of plan.jsonl: the effects of a frame that were simulated or left out, and why.
#pragma once

#include <string>

#include "pipeline/frame_pipeline.h"

namespace pleinair {

// One frame's. Times are in milliseconds, bounds in 8-bit code values at the frame's exposure.
std::string PlanLine(const Frame& frame, const FrameResult& result, const EffectSettings& settings);

}  // namespace pleinair
