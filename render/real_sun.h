// Whether a real pixel has sun that a new shadow can take away: what the composite decides, pixel
// by pixel, for who has to know it before.
#pragma once

#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// A real pixel as the camera and the model have it; all radiances in one unit.
struct RealPixel {
  glm::vec3 observed{0.0f};  // The camera's.
  bool clipped = false;      // Then a lower bound.
  glm::vec3 lit{0.0f};       // The model's, with all of the disc seen.
  glm::vec3 shaded{0.0f};    // And with none.
  float model_visibility = 0.0f;
  float edge_distance_px = 0.0f;  // SurfaceView's.
  bool albedo_measured = false;
};

// The picture that the pixel is in. References live for the call only.
struct RealPicture {
  const RgbImage& camera_radiance;
  const Gray8Image& clipped;  // May be empty: nothing was clipped.
  const SurfaceView& view;
  float gain = 1.0f;  // From camera_radiance to the pixel's unit.
};

// Share of the disc that the pixel at a place sees without virtual objects. Its log radiance, per
// channel, is held against two predictions: lit (l) and shaded (d). With noise sigma (the albedo
// against that of the survey, in log) the log odds of lit over shaded are
//   ((x - d)^2 - (x - l)^2) / (2 sigma^2);
// the median of three channels stands against one that is dead or coloured. Unless that alone
// agrees with the mesh, it is the median of the medians of three rows of three pixels on the same
// plane, the pixel in their middle: a joint between bricks or a pebble is narrower than a shadow,
// whose straight edges these medians keep. What the mesh says adds its own log odds, so that dark
// ground under a weak sun does not pass for shadow; near an edge of the model the mesh may be wrong
// about the place, and says nothing.
//
// Accuracy  the shader's to rounding: a pixel at the turning point may fall to either side.
float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px);

// One pixel's albedo against the model's, standard deviation in log: bricks, joints, stains around
// a survey texel's mean; a material's guess is worse.
inline constexpr float kLogSigmaMeasured = 0.25f;
inline constexpr float kLogSigmaGuessed = 0.5f;
// What is left of it in the median: what neighbours share, a guess first of all.
inline constexpr float kSharedLogSigmaMeasured = 0.2f;
inline constexpr float kSharedLogSigmaGuessed = 0.35f;
inline constexpr int kAroundPx = 2;  // From one of the three to the next.
// Least cosine between the two normals.
inline constexpr float kOnePlaneCosine = 0.95f;
// The mesh is right about sun or shade in 19 of 20 pixels away from its edges (it lacks trees and
// roof edges), and its edges are good to some pixels.
inline constexpr float kMeshLogOdds = 2.944f;
inline constexpr float kTrustedEdgeDistancePx = 6.0f;

}  // namespace pleinair
