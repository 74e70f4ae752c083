// The camera's noise in samples, and which samples black or white may clip.
#pragma once

#include <span>

#include "calib/camera_noise.h"
#include "estimation/diffuse_sample.h"

namespace pleinair {

// Writes radiance_stddev_rgb: the camera's noise over the sample's pixels, infinite in a channel
// that black or white may cut off. Where it is infinite already, the channel is clipped and stays
// so. `exposure` is the factor from radiance to the camera's signal.
//
// All decisions use a sample's predicted signal, not its measured one: its transport under the
// light that the medians of the samples support, clipped samples included. The reason is that
// leaving out only samples that happen to be clipped keeps the darker ones. Where more than a few
// of a plane's sunlit or shaded samples are clipped, all of these are left out.
//
// The relative noise is common to the samples of one plane, sunlit or shaded. Individual noise
// would give more weight to samples whose albedo is assumed too bright. Where a plane's samples
// differ by little else (an overcast day), the fit would explain that by light: a recording's sky
// came out a quarter too weak.
void ApplySignalNoise(const SignalNoise& noise, double exposure, std::span<DiffuseSample> samples);

}  // namespace pleinair
