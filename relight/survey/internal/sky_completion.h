// The entire sky from the part of it that a map shows.
#pragma once

#include "scene/image.h"

namespace pleinair {

// Replaces what is not sky in a lat-long image. Below the horizon it becomes black. Above it, where
// surfaces hide the sky, it becomes the mean of the row's visible sky times a factor that is
// carried over smoothly from the sky around. Skies change with elevation first, and are brightest
// low down, where buildings hide them. Near surfaces the map may show what the mesh lacks, an eave
// or a chimney. Pixels there that are far from what the sky farther off predicts are replaced as
// well. `shows_sky`: not zero where the image sees past the scene, above the horizon.
void CompleteSky(const Gray8Image& shows_sky, RgbImage& image);

// Fills pixels of zero weight from their surroundings, coarser the farther away (push-pull); pixels
// with weight keep their value. The image wraps in x. Black where no pixel has weight.
void FillPushPull(const GrayImage& weight, RgbImage& image);

}  // namespace pleinair
