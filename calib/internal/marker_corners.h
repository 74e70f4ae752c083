// Corners of a marker to a part of a pixel.
#pragma once

#include <array>

#include <glm/vec2.hpp>

#include "scene/image.h"

namespace pleinair {

// Where lines along the sides cross; each line through the steepest rise from black to white across
// the side, near the corner (a lens bends long sides). `cells` a side, border included: a search
// ends within a cell of the side. A marker whose sides are not that clear keeps its corners.
std::array<glm::dvec2, 4> RefinedMarkerCorners(const Gray8Image& picture,
                                               const std::array<glm::dvec2, 4>& corners_px,
                                               int cells);

}  // namespace pleinair
