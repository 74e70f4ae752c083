// White diffuse balls in the light of an environment map.
#pragma once

#include <vector>

#include "apps/viewer/viewed_frame.h"
#include "session/picture_display.h"

namespace pleinair {

// One above each object's place, or none without objects. `environment`: lat-long, the light there,
// with the sun.
std::vector<ShadedBall> BallsAt(const std::vector<VirtualObjectEntry>& objects,
                                const RgbImage& environment,
                                const Frame& frame,
                                const PictureDisplay& display);

}  // namespace pleinair
