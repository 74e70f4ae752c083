// What a camera makes of light beyond its stated response: expected of a frame, and as fitted.
#pragma once

#include <glm/vec3.hpp>

#include "calib/response_correction.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"
#include "scene/frame.h"

namespace pleinair {

// Linear frames have hardly any error, 8-bit frames whose exposure is stated little, and those of a
// camera of which nothing is known much.
CameraErrors ExpectedCameraErrors(const Frame& frame);

// The correction that `fit` found, with light in the units of the fit times `unit_rgb`. `camera` is
// the fit's prior.
ResponseCorrection CorrectionOf(const CameraErrors& camera,
                                const LightingFit& fit,
                                const glm::dvec3& unit_rgb);

}  // namespace pleinair
