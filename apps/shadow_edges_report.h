// The report of `pleinair calibrate north --shadow-edges`: the angle between marked real shadows
// and the computed sun.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"

namespace pleinair {

// `stated_north_rad` is the stated true azimuth of the model's +Y. The report to print, as text or
// JSON. Throws std::runtime_error, one line: a bad table, a mark in a frame that there is not or
// cannot be read, or outside its picture.
std::string ReportShadowEdges(const Sequence& sequence,
                              FrameKind frames,
                              const std::filesystem::path& marks_file,
                              double stated_north_rad,
                              bool json);

}  // namespace pleinair
