// How light on virtual objects is found.
#pragma once

#include <cstdint>

#include "objects/direct_daylight.h"
#include "relight/transport/transport.h"

namespace pleinair {

// How virtual objects get light other than the sun's direct light.
enum class ObjectLight {
  // Rays at their vertices, the most accurate for objects that stand still; or at a single probe
  // where a frame's plan says so.
  kGather,
  kVolume,       // The irradiance volume, operator and maps folded once per sun direction.
  kVolumeByMap,  // The same volume, by an environment map made and pushed through for each frame.
  kSingleProbe,  // Rays at a single probe among the objects, for all of them.
};

// Light on objects found at a single probe: for light whose variation over them is not visible.
struct SingleProbeOptions {
  static constexpr int kMostShBands = 12;
  int rays = 4096;   // Over the sphere. Converged: many, up to 2^20.
  int sh_bands = 7;  // 1 to kMostShBands. Of a small source's light 3 miss up to 9 %, 7 up to 4 %.
  std::uint64_t seed = 1;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// How light straight from the sky on virtual objects is found, and their shadows in it on real
// surfaces.
enum class Daylight {
  kGather,   // As all other light: by the rays, probes or map that ObjectLight says.
  kSamples,  // By samples of the sky: sharp shadows through windows.
};

// Rays at the vertices of objects that move: for how many vertices they are cast in a frame. Those
// of the others follow from what was found before (LightInMotion).
struct GatherInMotionOptions {
  int vertices_per_frame = 256;  // While an object moves. 0: all, as where they stand still.
  int vertices_at_rest = 1024;   // In frames after that, until all have been. 0: all at once.
  // Rays of a vertex in a coarse first frame (LightSteps::kFirst). 0: as many as in others.
  int rays_at_first = 64;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

struct ObjectLightOptions {
  ObjectLight route = ObjectLight::kGather;
  GatherOptions gather;
  GatherInMotionOptions in_motion;
  SingleProbeOptions single_probe;
  Daylight daylight = Daylight::kGather;
  DirectDaylightOptions direct_daylight;  // Used for kSamples alone.
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

}  // namespace pleinair
