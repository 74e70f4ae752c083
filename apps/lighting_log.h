// lighting.jsonl: one line a frame.
#pragma once

#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "datasets/lighting_record.h"
#include "pipeline/frame_pipeline.h"
#include "scene/frame.h"

namespace pleinair {

// The line of a frame that was done, without the line's end.
// `sky_image`: where its picture was written; empty: nowhere. `latency_ms`: of a live frame.
std::string LightingLine(const Frame& frame,
                         const FrameResult& result,
                         const std::string& sky_image,
                         std::optional<double> latency_ms = std::nullopt);

// The line of a frame that was not.
std::string FailureLine(const FrameError& error);

// What scoring would read back of a frame's line; the sky's shape is left out.
LightingRecord RecordOf(int frame, const tl::expected<FrameResult, FrameError>& result);

}  // namespace pleinair
