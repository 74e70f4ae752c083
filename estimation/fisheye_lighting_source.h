// Sun and sky from a fish-eye camera that looks at the sky (grosch-2007).
#pragma once

#include <cstdint>
#include <memory>

#include "calib/fisheye_camera.h"
#include "estimation/fisheye_sky.h"
#include "estimation/lighting_source.h"
#include "scene/sky_regions.h"

namespace pleinair {

struct FisheyeLightingOptions {
  SkyRegions regions{};                    // That the sky's radiance is reported in.
  SkyDetail detail = SkyDetail::kPicture;  // Of the sky that lights the scene.
  // For a clipped disc: samples of the room camera's view that tell the sun. 1 .. 100000.
  int samples = 500;
  std::uint64_t seed = 1;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// The sky's basis is one shape, the picture's own. The sun's disc is measured in the picture; where
// the picture clips it, sun patches that the frame's camera sees tell its irradiance (the outdoor
// fit with the sky held), and where there are none, the clear-sky beam does, with its deviation.
// A frame without a fish-eye picture is a failure of that frame.
std::unique_ptr<LightingSource> MakeFisheyeLightingSource(const FisheyeCamera& camera,
                                                          const FisheyeLightingOptions& options);

}  // namespace pleinair
