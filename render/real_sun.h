// Whether a real pixel has sun that a new shadow can remove: the composite's decision for each
// pixel, for callers that need it before.
#pragma once

#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// A real pixel as the camera and the model have it; all radiances in one unit.
struct RealPixel {
  glm::vec3 observed{0.0f};  // The camera's radiance.
  bool clipped = false;      // Then `observed` is a lower bound.
  glm::vec3 lit{0.0f};       // The model's radiance with all of the disc visible.
  glm::vec3 shaded{0.0f};    // The same with none of it.
  float model_visibility = 0.0f;
  float edge_distance_px = 0.0f;  // SurfaceView's.
  bool albedo_measured = false;
};

// The picture that the pixel is in. References live for the call only.
struct RealPicture {
  const RgbImage& camera_radiance;
  const Gray8Image& clipped;  // May be empty: nothing was clipped.
  const SurfaceView& view;
  float gain = 1.0f;  // Factor from camera_radiance to the pixel's unit.
};

// Returns the share of the disc that the pixel at (x_px, y_px) sees without virtual objects. Its
// log radiance x, per channel, is compared with two predictions: lit (l) and shaded (d). With noise
// sigma (the albedo against that of the survey, in log) the log odds of lit over shaded are
//   ((x - d)^2 - (x - l)^2) / (2 sigma^2),
// to which the mesh adds its own, so that dark ground under a weak sun is not treated as shadow.
// Near an edge of the model the mesh may be wrong about the place, and adds nothing.
//
// A radiance between the predictions and far from both supports neither: the light is wrong there,
// or the surface is another one. Between two deviations over shade and two below sun (around the x
// of even odds) a pixel is partly in the sun: what a new shadow leaves of it falls evenly, in log,
// from all to that of shade over sun. A step in between would cover the shadow with specks. The
// median over three channels is robust to one that is dead or coloured.
//
// Where that disagrees with the mesh, it is replaced by the median of the medians of three rows of
// three pixels on the same plane, with the pixel in the middle. A joint between bricks or a pebble
// is narrower than a shadow, whose straight edges these medians keep.
//
// A real shadow's edge is as wide as the disc and the lens make it. Where the median of one side's
// three pixels is lit and that of the other side is not, the pixel has the share that its radiance
// has between theirs. Otherwise a new shadow would leave pixels there darker than shade, or
// brighter.
//
// Accuracy  equal to the shader's up to rounding: a pixel at the bound of an edge, or of agreement
//           with the mesh, may fall to either side.
float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px);

// By the same evidence: whether the pixel is more likely in the sun than in shade, and at an edge
// whether it has half of the disc.
bool IsLikelierLit(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px);

// One pixel's albedo against the model's, standard deviation in log: bricks, joints, stains around
// a survey texel's mean; a material's guess is worse.
inline constexpr float kLogSigmaMeasured = 0.25f;
inline constexpr float kLogSigmaGuessed = 0.5f;
// The part of it that the median keeps: errors that neighbours share, such as a wrong guess.
inline constexpr float kSharedLogSigmaMeasured = 0.2f;
inline constexpr float kSharedLogSigmaGuessed = 0.35f;
inline constexpr int kAroundPx = 2;  // From one of the three to the next.
// Least cosine between the two normals.
inline constexpr float kOnePlaneCosine = 0.95f;
// A lit pixel is asked for an edge where it has less than this share of the predicted sun: one
// deviation of the shared errors.
inline constexpr float kSurelyLit = 0.8f;
// Deviations of the shared errors over shade, or below sun, from which on a pixel is in between.
inline constexpr float kSurelySigmas = 2.0f;
// Half the least width, in log, of what is in between: where sun and shade differ by less than four
// deviations.
inline constexpr float kLeastHalfBetween = 0.02f;
// Where shade has so much of sunlight's radiance, both are one, and shares are even.
inline constexpr float kEvenLeft = 0.999f;
// Two sides of an edge differ by at least this part of what is in between: less is a pattern of
// the surface.
inline constexpr float kLeastEdgeStep = 0.5f;
// Nearer to one of its sides a pixel is not within an edge.
inline constexpr float kLeastEdgeShare = 0.1f;
// The mesh is assumed right about sun or shade in 19 of 20 pixels away from its edges (it lacks
// trees and roof edges). Its edges are accurate to some pixels.
inline constexpr float kMeshLogOdds = 2.944f;
inline constexpr float kTrustedEdgeDistancePx = 6.0f;

}  // namespace pleinair
