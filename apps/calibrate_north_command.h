// `pleinair calibrate north`: how far a model's north is off, from the shadows in recorded frames.
#pragma once

#include <filesystem>
#include <string>

#include "datasets/frame_source.h"
#include "pipeline/shadow_direction.h"
#include "sunmodel/north.h"

namespace pleinair {

struct CalibrateNorthOptions {
  std::filesystem::path sequence;
  FrameKind frames = FrameKind::kLinear;
  NorthKind model_north = NorthKind::kTrue;  // The stated north of the model's +Y.
  MagneticModelFile magnetic;
  // CSV of frame, x and y in pixels: places on shadows' edges that a person has marked. Empty: the
  // pictures are searched.
  std::filesystem::path shadow_edges;
  bool json = false;
};

// The report to print. Bad frames are left out and named. Throws std::runtime_error or
// std::invalid_argument, one line.
std::string RunCalibrateNorth(const CalibrateNorthOptions& options);

// One line: the angle between real and virtual shadows, or why there is none.
std::string DescribeShadowDirection(const ShadowDirection& shadow);

}  // namespace pleinair
