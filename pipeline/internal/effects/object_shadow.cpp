// The sun's shadow on virtual objects: of real casters and their own.
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {
namespace {

class ObjectShadow : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    return SunOnObjects(stage_, frame);
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override { return {Effect::kSunShading}; }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.effects.object_shadow = true;
  }
};

}  // namespace

const EffectDefinition kObjectShadowEffect{
    .name = "object-shadow",
    .help = "shadows on virtual objects: real ones and their own",
    .rms_share = 0.1,
    .make = MakeEffect<ObjectShadow>};

}  // namespace pleinair
