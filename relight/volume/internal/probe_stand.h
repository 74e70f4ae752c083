// Where probes really stand: clear of surfaces, and whether in free air or in a wall.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/volume/internal/probe_rays.h"
#include "relight/volume/probe_operator.h"
#include "scene/ray_caster.h"

namespace pleinair::internal {

// Points near `position_m` from which rays may start. The position alone where no surface passes
// within a thousandth of `spacing_m` of it. Where one does, a ray would see either side by chance.
// Then points twice as far off, on both sides of a sheet and in all the corners of an edge. Empty
// where every such point touches another surface.
std::vector<glm::vec3> ClearStands(const RayCaster& caster,
                                   const glm::vec3& position_m,
                                   float spacing_m);

// Whether each probe of `grid` stands in free air, from what its rays met.
//
// A probe is taken to be in a wall when most surfaces that it sees turn their back to it and hardly
// any sky is seen. It is not when there is a free line from it to a neighbour in free air. So
// a room of single sheets wound the wrong way stays usable as long as one of its probes sees the
// sky; in a solid, or under the ground, no line leads out. A probe without a stand is in a wall.
// Not detected: a solid wound inside out, whose probes stay valid and dark.
//
// Shape  stands_m, counts: one entry a probe.
std::vector<std::uint8_t> InFreeAir(const RayCaster& caster,
                                    const ProbeGrid& grid,
                                    std::span<const std::optional<glm::vec3>> stands_m,
                                    std::span<const RayCounts> counts,
                                    int rays_per_probe);

}  // namespace pleinair::internal
