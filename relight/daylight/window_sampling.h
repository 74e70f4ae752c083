// Direct daylight as a few distant lights, drawn from the sky where it is seen through windows
// (grosch-2007, section 7).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/daylight/windows.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

struct BoundingSphere {
  glm::dvec3 centre_m{0.0};
  double radius_m = 0.0;
};

// Around the box around all points. Throws std::invalid_argument where there is none, or one is not
// finite.
BoundingSphere BoundingSphereOf(std::span<const glm::vec3> points_m);

enum class DaylightRestriction {
  kWindows,    // Drawn from the sky that can reach the object through a window.
  kRejection,  // Drawn from the entire sky until enough of the draws come through a window.
  kWholeSky,   // Drawn from the entire sky.
};

struct DaylightSamplingOptions {
  int samples = 64;  // 1 to 65536, which is converged.
  DaylightRestriction restriction = DaylightRestriction::kWindows;
  std::uint64_t seed = 1;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// A distant light. The sum of all lights that a surface sees, each times its cosine, estimates the
// surface's irradiance from the sky.
struct DaylightSample {
  glm::vec3 direction_enu{0.0f, 0.0f, 1.0f};  // Unit, towards the light.
  glm::vec3 irradiance_rgb{0.0f};             // Normal to the beam.
};

struct DaylightSamples {
  std::vector<DaylightSample> samples;
  // Share of the sky's light (radiance over solid angle, RGB added up) that the windows let through
  // to the object's bounding sphere; 1 for the entire sky.
  double sky_share = 0.0;
  std::string why_none;  // Empty where there are samples.
};

// Radiance of SkyTable's cells under the sky of `lighting`, whose components `shapes` are.
// Throws  std::invalid_argument where their numbers differ.
std::vector<glm::vec3> SkyRadianceTable(const Lighting& lighting,
                                        std::span<const std::shared_ptr<const SkyShape>> shapes);

// Set up once per pose of the object.
//
// Method    A direction leads from the object through a window's convex hull when, seen along it,
//           the bounding sphere reaches to the inner side of every edge. These are grosch-2007's
//           planes through the edges tangent to the sphere, without a special case where the sphere
//           meets an edge. The sky's cells for which that can hold, of any window, are kept, each
//           once. One sample is drawn from each of `samples` equal parts of the kept light. Parts
//           follow a Hilbert curve, so that each is a compact piece of sky. A sample's place in
//           its part stays, so that it keeps its piece of sky while the picture changes little.
// Unbiased  over seeds: nothing that can reach the object is left out. A sphere that meets a
//           window's opening is taken to see all of the sky.
// Ignores   which side is inside. For an object outdoors ask SeesSkyPastWindows first, and draw
//           from the entire sky.
class DaylightSampler {
 public:
  // Throws std::invalid_argument for bad options, windows or sphere.
  DaylightSampler(std::span<const Window> windows,
                  const BoundingSphere& object,
                  const DaylightSamplingOptions& options);

  // `sky_radiance` has SkyTable's cells, the sun's disc not among them. Throws
  // std::invalid_argument for another length, or a value below 0 or not finite, naming the cell.
  DaylightSamples Draw(std::span<const glm::vec3> sky_radiance) const;

  // Bound of the irradiance that a point in the object's sphere gets straight from that sky, and of
  // what the object hides of it from any other: all that comes through windows, met head-on.
  glm::vec3 LargestIrradiance(std::span<const glm::vec3> sky_radiance) const;

 private:
  DaylightSamplingOptions options_;
  std::vector<bool> through_window_;  // Per cell.
  std::vector<std::uint32_t> kept_;   // Cells, along the curve.
};

}  // namespace pleinair
