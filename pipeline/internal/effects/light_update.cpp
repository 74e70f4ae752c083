// Recomputes light on virtual objects as the sun or the sky changes; without this effect the light
// of an earlier sun is used.
#include <algorithm>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_on_objects.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

class LightUpdate : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    return HasOlder(frame) ? Bound{kWhiteCode, "light computed for an earlier sun or sky"}
                           : Bound{0.0, "all light is of the current sun and sky"};
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override { return kOnLightAtVertices; }
  // In proportion to the sun's motion since.
  double RmsShare(const EffectFrame& frame, double usual) override {
    double sun_motion_rad =
        stage_.Light().Done(frame.light.mode).SunMotionRad(frame.basis, frame.lighting);
    if (stage_.AnyGlossy()) {
      sun_motion_rad = std::max(sun_motion_rad,
                                stage_.Mirror().Done().SunMotionRad(frame.basis, frame.lighting));
    }
    constexpr double kADegree = 0.005;
    return std::clamp(kADegree * DegFromRad(sun_motion_rad), usual, kProbeShadingEffect.rms_share);
  }

 private:
  // Within a budget the plan may choose any way, and reports where that way has older light.
  bool HasOlder(const EffectFrame& frame) {
    const LightCosts& costs = frame.light.costs;
    return (frame.has_budget ? costs.AnyHasOlder() : costs.Of(frame.light.mode).HasOlder()) ||
           (stage_.AnyGlossy() && stage_.Mirror().Cost(frame).HasOlder());
  }
};

}  // namespace

const EffectDefinition kLightUpdateEffect{
    .name = "light-update",
    .help = "light on objects is recomputed as the sun moves; always so without a budget",
    .rms_share = 0.03,
    .make = MakeEffect<LightUpdate>,
    .is_way_of_others = true};

}  // namespace pleinair
