// Windows of a site: the openings through which sky is seen from inside. grosch-2007 takes them as
// known; here they are also found by rays.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// A flat polygon in the world, convex or not, of either winding.
struct Window {
  std::string name;
  std::vector<glm::dvec3> polygon_m;

  // Throws std::invalid_argument naming the window and what is wrong: less than three corners, one
  // that is not finite, no area, or a corner farther than a hundredth of the polygon's size from
  // its plane.
  void Validate() const;
};

struct WindowSearchOptions {
  // Over the entire sphere, from each point inside. A window of a thousandth of the sphere (1.3 m^2
  // in 10 m) gets 33 of them. Converged: as many as wished, up to 2^22.
  int rays_per_point = 32768;
  // Openings are found to a cell; larger for walls of more than 2048 cells.
  double cell_m = 0.01;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

struct FoundWindows {
  // "window 1", "window 2", ... the one with most rays for its area first.
  std::vector<Window> windows;
  std::size_t sky_rays = 0;               // How many of the cast rays reached the sky,
  std::size_t sky_rays_past_windows = 0;  // and how many of these through no window.

  // No sky is seen.
  bool Closed() const { return sky_rays == 0; }
  // Sky comes from elsewhere, too: a courtyard, a missing wall, a point outdoors.
  bool Open() const;
  std::string Summary() const;  // One line.
};

// Finds the windows of the room that `inside_points_m` lie in (objects and cameras: each sees its
// own part).
//
// Method  Rays that reach the sky leave the room through a plane of it that other rays hit. Where
//         they cross that plane, a connected part of it that no coplanar triangle covers is an
//         opening, a window if half of its rim or more is that plane's wall. Of several openings in
//         a row the one with most rays for its area is taken. Walls may be sheets or slabs, cut
//         into any triangles: their joints and boundary loops are not looked at.
// Result  polygons lie in the wall's inner plane and are up to a cell and a half too large.
// Not     found: an opening as wide and high as the room, which has no wall around it.
// Throws  std::invalid_argument for bad options or a point that is not finite.
FoundWindows FindWindows(const Mesh& mesh,
                         std::span<const glm::dvec3> inside_points_m,
                         const WindowSearchOptions& options = {});

// Whether more than 2 % of the rays that reach the sky from `points_m` miss all windows by more
// than 5 cm, the error of a polygon measured by hand. Then light must not be restricted to the
// windows.
bool SeesSkyPastWindows(const RayCaster& caster,
                        std::span<const Window> windows,
                        std::span<const glm::dvec3> points_m);

}  // namespace pleinair
