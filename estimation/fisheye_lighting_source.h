// Sun and sky from a fish-eye camera that looks at the sky (grosch-2007).
#pragma once

#include <cstdint>
#include <memory>

#include "calib/fisheye_camera.h"
#include "estimation/fisheye_sky.h"
#include "estimation/lighting_source.h"
#include "scene/sky_regions.h"

namespace pleinair {

// Set-up of the source.
struct FisheyeLightingOptions {
  SkyRegions regions{};                    // In which the sky's radiance is reported.
  SkyDetail detail = SkyDetail::kPicture;  // Detail of the sky that lights the scene.
  // Samples of the frame's own view, which check the sky's light, and determine the sun where the
  // sky's picture does not. 1 .. 100000.
  int samples = 500;
  std::uint64_t seed = 1;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// The sky's basis is one shape, the picture's own. The sun's disc is measured in the picture. Where
// the picture clips it, its irradiance is fitted to sun patches that the frame's camera sees (the
// outdoor fit with the sky held). Where there are none, it is that of the clear-sky beam, with its
// deviation. A frame without a fish-eye picture is a failure of that frame, and so is a black one
// by day.
//
// The surfaces in the frame's own picture correct what is far off. Where their
// patches of sun are less than a third of what the fish-eye's sun gives, or more than three times,
// the sun is fitted to them. Where the entire picture is 1.5 times as bright as the light makes it,
// or more, or less, or a channel is, the light is scaled to it: LightingEstimate::sky_camera has
// both. Of a picture whose exposure is not known the light is in its units.
std::unique_ptr<LightingSource> MakeFisheyeLightingSource(const FisheyeCamera& camera,
                                                          const FisheyeLightingOptions& options);

}  // namespace pleinair
