// What the camera's own noise makes of samples, and which of them its black and white cut off.
#pragma once

#include <span>

#include "calib/camera_noise.h"
#include "estimation/diffuse_sample.h"

namespace pleinair {

// Writes radiance_stddev_rgb: the camera's noise over the sample's pixels, infinite in a channel
// that black or white may cut off. Where it is infinite already the channel is clipped, and stays
// so. `exposure` leads from radiance to the camera's signal.
//
// All of this goes by what a sample should show, not by what it does: by its transport under the
// light that the medians of the samples speak for, clipped ones among them. Leaving out those that
// happen to be clipped keeps those that happen to be darker; where more than a few of a plane's
// sunlit or shaded samples are, all of them are left out. And the relative noise is that of the
// samples of one plane together, sunlit or shaded: a noise of their own would make the samples of
// an albedo that is believed too bright count more, and where a plane's samples differ by little
// else (an overcast day) the fit takes that for light: a recording's sky came out a quarter too
// weak.
void ApplySignalNoise(const SignalNoise& noise, double exposure, std::span<DiffuseSample> samples);

}  // namespace pleinair
