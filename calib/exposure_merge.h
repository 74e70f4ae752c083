// Pictures of one view at several exposures, merged to one of high dynamic range.
#pragma once

#include <span>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "scene/image.h"

namespace pleinair {

// An 8-bit picture and the linear factor from radiance to its [0, 1]: exposure time times ISO / N^2
// where nothing better is known (the merged radiance is relative then).
struct ExposedPicture {
  Rgb8Image codes;
  double exposure = 0.0;
};

// The merged picture; all images have the pictures' size. Radiance is scene-linear.
struct MergedExposures {
  RgbImage radiance;
  RgbImage stddev;  // By the noise model; without meaning where clipped or at_noise_floor.
  // 1 where a channel is clipped in every picture: its radiance is a lower bound.
  Gray8Image clipped;
  // 1 where a channel is at the noise floor in every picture that does not clip it.
  Gray8Image at_noise_floor;
  // How far the pictures differ where two or more hold a pixel's green: the largest difference over
  // the merged value, median over the pixels. 0 where they share none.
  double median_difference = 0.0;
};

// Returns the mean over the pictures, for each channel separately, with weights of 1 / variance
// (shot noise, read noise and the code's rounding). The variances are evaluated at the merged
// value, not at each picture's own: weights that depend on a measurement's own noise favour low
// values.
//
// Left out  codes from kClippedFromCode on, or from one below where the curve's upper end is flat
//           (to 0.5 %); up to kNoiseFloorUpToCode unless there is nothing else.
// Throws    std::invalid_argument: no picture, different sizes, an exposure that is not positive.
MergedExposures MergeExposures(std::span<const ExposedPicture> pictures,
                               const ResponseCurve& response,
                               const CameraNoise& noise = {});

}  // namespace pleinair
