// A frame's works as the plan knows them: which effects need them, and what they cost.
#pragma once

#include <cstddef>
#include <vector>

#include "objects/vertex_light.h"
#include "pipeline/effect_plan.h"
#include "pipeline/internal/kept_effects.h"

namespace pleinair {

// Works by name, in the order of the plan's list.
enum WorkIndex : std::size_t {
  kVertexLight,
  kVertexLightNow,
  kOnePlaceLight,
  kOnePlaceLightNow,
  kLoneLight,
  kLoneLightNow,
  kBetweenObjects,
  kDaylightSamples,
  kInfluence,
  kObjectView,
  kSunOnSurfaces,
  kSunOnObjects,
  kMirrorImage,
  kMirrorImageNow,
  kDrawSun,
  kDrawVolumes,
  kDrawRelit,
  kDrawBlur,
  kNoise,
  kWorkCount
};

// Effects that need light on the objects, and those on real surfaces.
inline constexpr EffectSet kOnLightAtVertices{Effect::kProbeShading,
                                              Effect::kDaylight,
                                              Effect::kSkyOcclusion,
                                              Effect::kColourBleeding,
                                              Effect::kGlossyReflection};

inline constexpr EffectSet kOnInfluence{Effect::kSkyOcclusion, Effect::kColourBleeding};
inline constexpr EffectSet kOnSurfaces{
    Effect::kSunShadow, Effect::kSkyOcclusion, Effect::kColourBleeding};
inline constexpr EffectSet kShadows{Effect::kSunShadow, Effect::kObjectShadow};

// Of light on objects, by the ways of finding it.
struct LightCosts {
  LightCost at_vertices;
  LightCost at_one_place;
  LightCost alone;   // At one place, without what objects do to each other.
  WorkCost between;  // That, at vertices, where it is a work of its own.
  bool between_is_apart = false;
  LightCost mirror;

  bool AnyHasOlder() const {
    return at_vertices.HasOlder() || at_one_place.HasOlder() || alone.HasOlder();
  }
  const LightCost& Of(const VertexLight::Mode& mode) const {
    if (mode.at == VertexLight::At::kVertices) return at_vertices;
    return mode.with_objects ? at_one_place : alone;
  }
};

struct FrameWorkCosts {
  LightCosts light;
  WorkCost daylight;
  WorkCost influence;
  WorkCost object_view;
  WorkCost sun_on_surfaces;
  WorkCost sun_on_objects;
  WorkCost noise;
  double draw_scale = 1.0;  // Of drawing, over its nominal time.
};

// Among how many frames what is made once is shared, and what is made for each sun.
struct WorkSharing {
  double frames_that_stand_still = 1.0;
  double frames_a_sun = 1.0;
};

// The work that finds light in that way, or makes it anew for this sun.
WorkIndex LightWork(const VertexLight::Mode& mode, Upto upto);

// By WorkIndex.
std::vector<WorkOffer> OfferWorks(const FrameWorkCosts& costs, const WorkSharing& sharing);

}  // namespace pleinair
