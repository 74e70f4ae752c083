// The analytic sky shapes, by name: the fit describes a sky's light as a mix of these.
#pragma once

#include <memory>
#include <string_view>

#include <glm/vec3.hpp>

#include "scene/sky_shape.h"
#include "sunmodel/clear_sky.h"

namespace pleinair {

// OvercastSkyLuminance's, grey: "overcast".
std::shared_ptr<const SkyShape> MakeOvercastSkyShape();
// ClearSkyDistribution's for the sun at `sun_direction_enu`: "clear". Looked up in cells of half a
// degree. Throws std::invalid_argument as ClearSkyDistribution does.
std::shared_ptr<const SkyShape> MakeClearSkyShape(
    const glm::dvec3& sun_direction_enu,
    double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm);

// The shapes above by name.
enum class SkyShapeKind { kUniform, kOvercast, kClear };
inline constexpr SkyShapeKind kAllSkyShapeKinds[] = {
    SkyShapeKind::kUniform, SkyShapeKind::kOvercast, SkyShapeKind::kClear};

// The name in settings and in lighting.jsonl.
std::string_view NameOf(SkyShapeKind kind);
// Whether the shape depends on the sun's direction.
bool TurnsWithTheSun(SkyShapeKind kind);
std::shared_ptr<const SkyShape> MakeSkyShape(
    SkyShapeKind kind,
    const glm::dvec3& sun_direction_enu,
    double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm);

}  // namespace pleinair
