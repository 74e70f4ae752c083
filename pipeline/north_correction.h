// A model's orientation that is only guessed, corrected by the shadows in its frames.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "datasets/frame_source.h"
#include "scene/mesh.h"
#include "sunmodel/site.h"

namespace pleinair {

struct NorthCorrection {
  // Whether shadows say anything; where not, `reason` says why, and north is what it was.
  bool determined = false;
  std::string reason;
  // Azimuth of the model's +Y, clockwise from true north, with the stated deviation as a normal
  // prior about 0. Without shadows 0 and the stated deviation.
  double north_azimuth_rad = 0.0;
  double stddev_rad = 0.0;
  // From the shadows only.
  double shadows_azimuth_rad = 0.0;
  double shadows_stddev_rad = 0.0;
  int frames = 0;  // That were looked at.
};

// Looks at up to 24 of the frames whose sun follows from place and time, evenly chosen, as
// ShadowDirectionFinder does: within 20 deg, or three stated deviations where these are more.
// Shadows that contradict the stated deviation by more than three of both change nothing.
//
// `site`         its model_north_azimuth_rad is not looked at.
// `open_frames`  gives the recording from its start, at each call.
// Cost           0.2 to 0.6 s a frame.
// Throws         std::invalid_argument for a deviation that is not positive, and as
//                ShadowDirectionFinder.
NorthCorrection CorrectNorth(const std::function<std::unique_ptr<FrameSource>()>& open_frames,
                             const Site& site,
                             const Mesh& mesh,
                             std::span<const std::string> diffuse_regions,
                             double stated_stddev_rad);

}  // namespace pleinair
