// Ground and walls of a reconstructed place, found as a coarse mesh of named surfaces.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/reconstruction/plane_fit.h"
#include "calib/reconstruction/reconstruction.h"

namespace pleinair {

// One flat surface.
struct SiteSurface {
  std::string name;
  Plane plane;  // Its normal points to the cameras' side.
  // Counter-clockwise seen from there; metres.
  std::vector<std::vector<glm::dvec3>> polygons;
  glm::dvec3 albedo{0.5};  // A guess: the hue of its points in the pictures, and a mean of 0.5.
  std::size_t points = 0;  // Number of points of the fit; 0: the plane is assumed.
  double rms_m = 0.0;      // Rms of their distances.
};

// One mark, in pixels of the photograph as the model has it.
struct SurfaceMark {
  std::size_t picture = 0;  // Into Reconstruction::pictures.
  glm::dvec2 pixel{0.0};
};

// Marks of a person on pictures. Three or more in one picture are the corners of a polygon, in
// order; fewer are places on the surface.
struct MarkedSurface {
  std::string name;  // "ground" is the ground.
  std::vector<SurfaceMark> marks;
};

// Limits of the search; metres.
struct SurfaceOptions {
  double tolerance_m = 0.1;      // Largest distance of a point to its plane; above 0.
  double camera_height_m = 1.6;  // Height of the lowest camera, where no points show the ground.
  double border_m = 30.0;        // Margin of the ground beyond everything else.
  std::size_t most_walls = 12;
  // Level, unit: along or across most walls, where known. The strongest wall uses it where it is
  // within 4 degrees of it.
  std::optional<glm::dvec3> wall_direction;
};

// The ground and the walls.
struct SiteSurfaces {
  std::vector<SiteSurface> surfaces;  // The ground first.
  std::vector<std::string> notes;
};

// Fits planes to the points and bounds them.
//
// Frame    +Z is up, metres.
// Ground   level; the lowest level plane of many points below the cameras, or where there is none
//          at camera_height_m below the lowest one, noted.
// Walls    upright; along or across the strongest one, unless half as many points more are on one
//          that is not. They reach from the ground to their highest points and meet each other
//          where they nearly do. Places through which cameras see points are open.
// Marks    surfaces whose names and places are given in place of walls that are found: upright or
//          level where their points allow, else as steep as these are; upright ones within 3
//          degrees of along or across the first one are so. Their outlines are the
//          marks of the picture with the most, moved to the ground and to each other where they
//          nearly meet them.
// Throws   std::runtime_error, one line: a marked surface without enough points inside its marks,
//          neither a wall nor ground found. std::invalid_argument for bad options.
SiteSurfaces FitSurfaces(const Reconstruction& world,
                         std::span<const MarkedSurface> marked,
                         const SurfaceOptions& options);

// OBJ and MTL; names of surfaces are groups and materials.
std::string ObjText(std::span<const SiteSurface> surfaces, const std::string& material_library);
std::string MtlText(std::span<const SiteSurface> surfaces);

}  // namespace pleinair
