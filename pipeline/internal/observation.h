// A lighting source's input for one frame at a prepared site.
#pragma once

#include "estimation/lighting_source.h"
#include "pipeline/sun_state.h"
#include "relight/prepared_scene.h"
#include "scene/frame.h"
#include "scene/surface_view.h"

namespace pleinair {

// Relative error of each plane's own albedo: of guesses; 0 with a survey.
double PlaneAlbedoStddev(const PreparedScene& scene);

// `frame` and `view` outlive the observation.
LightingObservation Observe(const PreparedScene& scene,
                            const ScaledClearSky& clear_sky,
                            const Frame& frame,
                            const SurfaceView& view,
                            const SunState& sun);

}  // namespace pleinair
