// The sun that an environment map shows, for maps whose place and time are not known or not
// certain.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// What the place of the sun was read from.
enum class MapSunKind {
  kDisc,     // A disc that holds a share of the map's light as only the sun does.
  kFlatTop,  // A small disc cut at the map's largest value.
  kPlateau,  // The middle of what is cut off: the sun and much of its glare.
  kGlow,     // The middle of a glow: the sun behind thin cloud, or cut off with its glare around.
};

struct MapSun {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};  // Unit, in the map's own frame.
  MapSunKind kind = MapSunKind::kDisc;
  double uncertain_rad = 0.0;  // How far the sun may be from there: a pixel, or the most of a top.
};

// Where the sun shines in the upper half of `map` (lat-long, finite, not negative); none where it
// is hidden (an overcast sky, a building before it) or was never there (a room).
//
// Method    The spot with the most light within a degree, or the middle of what is level. It is the
// sun where it outshines the sky
//           around, is round, and one of these holds. It has a tenth of the light of the rest; it
//           is a small disc cut at one level that nothing else in the map reaches; or it fades into
//           a glow of a few degrees that holds 2 % of the light; or it is most of what is cut at
//           the map's largest value, up to 16 degrees wide, and fades. Lamps and reflections in
//           windows hold less; bright clouds and windows are larger, or do not fade.
// Not       distinguished from the sun: one lamp that holds a tenth of a room's light, or one of
// two
//           degrees and more that is cut off, fades and holds 2 %.
std::optional<MapSun> FindMapSun(const RgbImage& map);

// Share of the upper half, by solid angle, that is cut off at the map's largest value and brighter
// than half of the rest by half. A sun that FindMapSun does not find may be there.
double ShareCutOff(const RgbImage& map);

}  // namespace pleinair
