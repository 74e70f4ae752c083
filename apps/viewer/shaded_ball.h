// White diffuse balls in the real light: what probes have stored, or an environment map says.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

#include "apps/viewer/viewed_frame.h"
#include "relight/volume/irradiance_volume.h"
#include "session/picture_display.h"

namespace pleinair {

// At `place_world_m`, whose light `environment` is: lat-long, with the sun.
ShadedBall BallIn(const RgbImage& environment,
                  const glm::dvec3& place_world_m,
                  const Frame& frame,
                  const PictureDisplay& display);

// At the volume's valid probes, without the sun's disc. Of more than kMostBalls, every so many.
inline constexpr std::size_t kMostBalls = 64;
std::vector<ShadedBall> BallsOf(const IrradianceVolume& volume,
                                const Frame& frame,
                                const PictureDisplay& display);

}  // namespace pleinair
