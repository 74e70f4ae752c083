// A model's orientation that is only guessed, corrected by the shadows in its frames.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "datasets/frame_source.h"
#include "scene/mesh.h"
#include "sunmodel/site.h"

namespace pleinair {

// The corrected orientation of a model.
struct NorthCorrection {
  // Whether shadows determine north. Where not, `reason` says why, and north is unchanged.
  bool determined = false;
  std::string reason;
  bool contradicts = false;  // Shadows determine a north that contradicts the stated deviation.
  // Azimuth of the model's +Y, clockwise from true north, with the stated deviation as a normal
  // prior about 0. Without shadows 0 and the stated deviation.
  double north_azimuth_rad = 0.0;
  double stddev_rad = 0.0;
  // From the shadows only, without the prior.
  double shadows_azimuth_rad = 0.0;
  double shadows_stddev_rad = 0.0;
  int frames = 0;  // Frames that were used.
};

// A north that is measured, with one stated as 0 to `stated_stddev_rad` as a normal prior.
struct WeighedNorth {
  double azimuth_rad = 0.0;
  double stddev_rad = 0.0;
};

// None where the two are more than three combined deviations apart.
std::optional<WeighedNorth> WeighNorth(double measured_azimuth_rad,
                                       double measured_stddev_rad,
                                       double stated_stddev_rad);

// Corrects north by the shadows in up to 24 frames, chosen evenly among those whose sun follows
// from place and time. ShadowDirectionFinder searches within 20 deg, or three stated deviations
// where these are more. Shadows change nothing where WeighNorth has none.
//
// `site`         its model_north_azimuth_rad is not used.
// `open_frames`  returns the recording from its start, at each call.
// Cost           0.2 to 0.6 s for each frame.
// Throws         std::invalid_argument for a deviation that is not positive, and as
//                ShadowDirectionFinder.
NorthCorrection CorrectNorth(const std::function<std::unique_ptr<FrameSource>()>& open_frames,
                             const Site& site,
                             const Mesh& mesh,
                             std::span<const std::string> diffuse_regions,
                             double stated_stddev_rad);

}  // namespace pleinair
