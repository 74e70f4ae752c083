#include "pipeline/internal/frame_works.h"

#include <string_view>

namespace pleinair {
namespace {

// Drawing, nominal: an object of 4000 faces over 4000 pixels at 640x480 that stands on the ground,
// neither it nor the camera moving, by software on two cores (bench/plan_bench.cpp).
constexpr double kDrawSunMs = 3.0;
constexpr double kDrawVolumesMs = 4.0;
constexpr double kDrawRelitMs = 1.5;
constexpr double kDrawBlurMs = 1.0;  // Of the objects' layer.

WorkOffer OfferDrawing(std::string_view name, double nominal_ms, double scale, EffectSet for_any) {
  return {name, nominal_ms, scale * nominal_ms, false, true, for_any};
}

}  // namespace

WorkIndex LightWork(const VertexLight::Mode& mode, Upto upto) {
  const bool is_current = upto == Upto::kCurrent;
  if (mode.at == VertexLight::At::kVertices) return is_current ? kVertexLightNow : kVertexLight;
  if (mode.with_objects) return is_current ? kOnePlaceLightNow : kOnePlaceLight;
  return is_current ? kLoneLightNow : kLoneLight;
}

std::vector<WorkOffer> OfferWorks(const FrameWorkCosts& costs, const WorkSharing& sharing) {
  const auto offer = [&](std::string_view name, const WorkCost& cost, EffectSet for_any) {
    const double expected_ms = cost.expected_ms -
                               cost.once_ms * (1.0 - 1.0 / sharing.frames_that_stand_still) -
                               cost.sun_ms * (1.0 - 1.0 / sharing.frames_a_sun);
    return WorkOffer{name, cost.nominal_ms, expected_ms, cost.is_kept, false, for_any};
  };
  std::vector<WorkOffer> works(kWorkCount);
  const auto offer_light = [&](WorkIndex work, std::string_view name, const LightCost& cost) {
    works[work] = offer(name, cost.lacking, kOnLightAtVertices.With(Effect::kSelfOcclusion));
  };
  const auto offer_now = [&](WorkIndex work, std::string_view name, const LightCost& cost) {
    works[work] = offer(name, cost.now, {Effect::kCurrentLight});
  };
  offer_light(kVertexLight, "light at vertices", costs.light.at_vertices);
  offer_light(kOnePlaceLight, "light at one place", costs.light.at_one_place);
  offer_light(kLoneLight, "light at one place, objects left out", costs.light.alone);
  offer_now(kVertexLightNow, "light at vertices, of this sun", costs.light.at_vertices);
  offer_now(kOnePlaceLightNow, "light at one place, of this sun", costs.light.at_one_place);
  offer_now(kLoneLightNow, "light at one place, objects left out, of this sun", costs.light.alone);
  works[kBetweenObjects] =
      offer("light between objects",
            costs.light.between,
            costs.light.between_is_apart ? EffectSet{Effect::kSelfOcclusion} : EffectSet());
  for (const WorkIndex work : {kVertexLight, kVertexLightNow, kBetweenObjects}) {
    works[work].with_all = {Effect::kLightVariation};
  }
  for (const WorkIndex work : {kOnePlaceLight, kOnePlaceLightNow}) {
    works[work].with_all = {Effect::kSelfOcclusion};
    works[work].without = {Effect::kLightVariation};
  }
  for (const WorkIndex work : {kLoneLight, kLoneLightNow}) {
    works[work].without = {Effect::kLightVariation, Effect::kSelfOcclusion};
  }
  works[kDaylightSamples] = offer("daylight samples", costs.daylight, {Effect::kDaylight});
  works[kInfluence] = offer("influence on surfaces", costs.influence, kOnInfluence);
  works[kObjectView] =
      offer("objects in view", costs.object_view, {Effect::kPenumbra, Effect::kGlossyReflection});
  works[kSunOnSurfaces] = offer("sun past objects", costs.sun_on_surfaces, {Effect::kSunShadow});
  works[kSunOnSurfaces].with_all = {Effect::kPenumbra};
  works[kSunOnObjects] = offer("sun on objects", costs.sun_on_objects, {Effect::kObjectShadow});
  works[kSunOnObjects].with_all = {Effect::kPenumbra};
  works[kMirrorImage] =
      offer("mirror image", costs.light.mirror.lacking, {Effect::kGlossyReflection});
  works[kMirrorImageNow] =
      offer("mirror image, of this sun", costs.light.mirror.now, {Effect::kCurrentLight});
  works[kMirrorImageNow].with_all = {Effect::kGlossyReflection};
  works[kDrawSun] = OfferDrawing("draw sun", kDrawSunMs, costs.draw_scale, {Effect::kSunShading});
  works[kDrawVolumes] =
      OfferDrawing("draw shadow volumes", kDrawVolumesMs, costs.draw_scale, kShadows);
  works[kDrawVolumes].without = {Effect::kPenumbra};
  works[kDrawRelit] =
      OfferDrawing("draw relit surfaces", kDrawRelitMs, costs.draw_scale, kOnSurfaces);
  works[kDrawBlur] =
      OfferDrawing("draw blur", kDrawBlurMs, costs.draw_scale, {Effect::kCameraBlur});
  works[kNoise] = offer("camera noise", costs.noise, {Effect::kCameraNoise});
  return works;
}

}  // namespace pleinair
