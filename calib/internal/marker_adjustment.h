// Least squares over the poses of markers and of the cameras that saw them.
#pragma once

#include <array>
#include <map>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "calib/marker_bundle.h"

namespace pleinair {

struct MarkerLayout {
  std::map<int, glm::dmat4> world_from_marker;          // By id.
  std::map<std::size_t, glm::dmat4> camera_from_world;  // By view.
};

// Squared errors of the corners of `square` as seen by a camera there; infinite where it cannot.
double SumSquaresPx(const Lens& lens,
                    const std::array<glm::dvec3, 4>& square,
                    const DetectedMarker& marker,
                    const glm::dmat4& camera_from_marker);

// What was seen of markers of one size.
struct SeenMarkers {
  const Lens& lens;
  const std::array<glm::dvec3, 4>& square;  // A marker's corners in its own frame.
  const std::vector<const MarkerView*>& views;
};

// Levenberg-Marquardt (Ceres) of at most `steps`, Huber's loss beyond 1 px. The reference marker
// stays. Markers and views that the layout does not have are left alone.
void AdjustMarkerLayout(const SeenMarkers& seen, int reference_id, int steps, MarkerLayout& layout);

}  // namespace pleinair
