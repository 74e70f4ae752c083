// Choices by a sequence where its session's options leave them open.
#pragma once

#include <memory>

#include "calib/response.h"
#include "datasets/sequence.h"
#include "estimation/lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "session/loaded_sequence.h"
#include "session/session_options.h"

namespace pleinair {

// The source of `options`; where none is given, fish-eye where frames have such a picture, else
// outdoor.
SourceKind SourceOf(const SessionOptions& options, const Sequence& sequence);
// The survey where there is one; else the materials where their albedo is known or assumed, or no
// light is estimated from them; else self-calibration.
AlbedoSource AlbedoSourceOf(const SessionOptions& options, const Sequence& sequence);
Daylight DaylightOf(const SessionOptions& options, const SequenceSite& site);
// The 8-bit camera's response. Throws as ResponseCurve::FromFile.
ResponseCurve ResponseOf(const SessionOptions& options, const Sequence& sequence);

// The source of `options`, or the default for the sequence. Throws std::runtime_error for one that
// the sequence has no data for.
std::unique_ptr<LightingSource> MakeSourceFor(const SessionOptions& options,
                                              const Sequence& sequence,
                                              double aerosol_optical_depth_500nm);

// Returns options.pipeline with what depends on the sequence filled in.
FramePipelineOptions PipelineOptionsFor(const SessionOptions& options,
                                        const LoadedSequence& loaded);

}  // namespace pleinair
