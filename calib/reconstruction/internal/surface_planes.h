// Planes of ground, walls and marked surfaces, without their outlines.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/reconstruction/surfaces.h"

namespace pleinair {

struct SurfacePlane {
  std::string name;
  PlaneFit fit;  // Members are indices of the reconstruction's points.
};

// The ground's height, and the points that show it; none where no points do.
std::optional<PlaneFit> FindGround(const Reconstruction& world, double tolerance_m);

// Upright planes with their points, strongest first; a plane of two walls with a gap between them
// is given twice, with one offset unless their points contradict that. They have no names. Points a
// few tolerances before or behind a wall are a part of it. All except the strongest are along or
// across it, unless another direction has half as many points more.
std::vector<SurfacePlane> FindWalls(const Reconstruction& world,
                                    double ground_m,
                                    const SurfaceOptions& options);

// Throws std::runtime_error where the marks hold too few points.
SurfacePlane FitMarked(const Reconstruction& world,
                       const MarkedSurface& marked,
                       double tolerance_m);

// Walls take the direction of the first one, or of its normal, where they are within 3 degrees of
// it and keep their points; the first one that of `options`.
void AlignDirections(const Reconstruction& world,
                     const SurfaceOptions& options,
                     std::span<SurfacePlane> walls);

}  // namespace pleinair
