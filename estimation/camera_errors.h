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

// Errors of the surfaces' colours look like a saturation, the same in every frame.
inline constexpr double kLeastSaturationStddev = 0.04;

// One of the camera's errors, as known so far.
struct LearnedError {
  double value = 0.0;
  double stddev = 0.0;  // 0: not an unknown.
};

// What is known after a fit that began with `expected` and ended with `found`: its own evidence is
// the difference of both, of which the share `part` counts in addition to `known`.
LearnedError WithEvidence(const LearnedError& known,
                          const LearnedError& expected,
                          const LearnedError& found,
                          double part);
// The same, but only until it is known to `least_stddev`: for evidence that errs by that much in
// all pictures alike.
LearnedError WithEvidenceDownTo(double least_stddev,
                                const LearnedError& known,
                                const LearnedError& found,
                                double part);

}  // namespace pleinair
