// Light of the sky alone between the patches of a scene.
#pragma once

#include "relight/transport/transport.h"

namespace pleinair {

inline FaceLight SolveSky(const PatchTransport& transport,
                          const PatchScene& scene,
                          const SkyShape& shape,
                          int bounces) {
  return transport.Solve(scene, transport.DirectFromSky(shape), bounces);
}

}  // namespace pleinair
