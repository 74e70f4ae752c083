// The sun on virtual objects.
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {
namespace {

class SunShading : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    const Bound bound = SunOnObjects(stage_, frame);
    if (bound.code_values == 0.0) return bound;
    if (!stage_.SunReachesObjects(frame)) return {0.0, "objects in the shadow of the scene"};
    return bound;
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(DrawingOf("draw sun", kDrawMs, frame, {Effect::kSunShading}));
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.effects.sun_shading = true;
  }

 private:
  static constexpr double kDrawMs = 3.0;  // Nominal: see kDrawObjectsMs.
};

}  // namespace

const EffectDefinition kSunShadingEffect{.name = "sun-shading",
                                         .help = "the sun on virtual objects",
                                         .rms_share = 0.2,
                                         .make = MakeEffect<SunShading>};

}  // namespace pleinair
