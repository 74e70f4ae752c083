// A run in words: in its report and log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/frame_loop.h"
#include "apps/run_command.h"
#include "apps/run_report.h"
#include "render/gl_context.h"

namespace pleinair {

std::string TitleOf(const Sequence& sequence);

// `frames`: how many there are; none: not known.
std::vector<std::string> DescribeSettings(const RunCommandOptions& options,
                                          const LoadedSequence& loaded,
                                          std::optional<std::size_t> frames,
                                          const GlDescription& gl);

// A line of the log; nothing for a frame that failed.
void LogLight(const FinishedFrame& finished, std::optional<std::size_t> of_frames);

std::string StoppedAt(const FrameError& error);
std::string InterruptedAfter(std::int64_t frames, std::optional<std::size_t> of_frames);

// Into the log: for a run of which some frames are done.
void SayWhereTheReportIs(const RunCommandOptions& options, const RunReport& report);

// Into the log. Throws std::runtime_error, with the first failure, where no frame succeeded.
void SayHowItEnded(const RunCommandOptions& options,
                   const RunReport& report,
                   const Sequence& sequence);

}  // namespace pleinair
