// Fixed functions of direction that a sky's light is a mix of.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Radiance over the upper hemisphere, scaled per channel so that an unoccluded horizontal plane
// gets irradiance 1. Immutable, safe from any thread.
class SkyShape {
 public:
  virtual ~SkyShape() = default;
  virtual std::string Name() const = 0;  // As in lighting.jsonl's sky_shape.
  // Zero on and below the horizon. `direction_enu` is unit.
  virtual glm::vec3 Radiance(const glm::vec3& direction_enu) const = 0;
};

std::shared_ptr<const SkyShape> MakeUniformSkyShape();
// OvercastSkyLuminance's, grey: "overcast".
std::shared_ptr<const SkyShape> MakeOvercastSkyShape();
// ClearSkyDistribution's for the sun at `sun_direction_enu`: "clear". Looked up in cells of half a
// degree. Throws std::invalid_argument as ClearSkyDistribution does.
std::shared_ptr<const SkyShape> MakeClearSkyShape(const glm::dvec3& sun_direction_enu);

// The shapes above by name: what the sky's light is fitted as a mix of.
enum class SkyShapeKind { kUniform, kOvercast, kClear };
inline constexpr SkyShapeKind kAllSkyShapeKinds[] = {
    SkyShapeKind::kUniform, SkyShapeKind::kOvercast, SkyShapeKind::kClear};

std::string_view NameOf(SkyShapeKind kind);
// Whether the shape is another one for another sun.
bool TurnsWithTheSun(SkyShapeKind kind);
std::shared_ptr<const SkyShape> MakeSkyShape(SkyShapeKind kind,
                                             const glm::dvec3& sun_direction_enu);

// The shape of a lat-long sky image (any size, without the disc), interpolated between its pixels'
// centres. What the image holds below the horizon is not looked at. A channel that is black all
// over the sky falls back to no light in that channel.
//
// Throws  std::invalid_argument for an image with defects, or with less than two rows.
std::shared_ptr<const SkyShape> MakeImageSkyShape(std::string name, const RgbImage& sky_radiance);

// Irradiance of a lat-long sky image on an unoccluded horizontal plane: the scale that
// MakeImageSkyShape takes out.
glm::dvec3 HorizontalIrradiance(const RgbImage& sky_radiance);

}  // namespace pleinair
