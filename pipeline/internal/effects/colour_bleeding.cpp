// Light that virtual objects reflect to real surfaces. Its work is that of sky-occlusion.
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {
namespace {

class ColourBleeding : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    const glm::vec3 of_objects =
        stage_.LargestAlbedo() * (stage_.LargestIrradianceOnObjects(frame) + SunOf(frame.lighting));
    if (IsDark(of_objects)) return {0.0, "no light"};
    const InfluenceReach& reach = stage_.Reach(frame);
    if (reach.largest_share == 0.0f) return {0.0, "no surface near an object in view"};
    if (reach.largest_share >= InfluenceReach::kDecisive) {
      return {kWhiteCode, "an object close to a surface"};
    }
    return {ChangeOfReached(frame, reach, glm::vec3(0.0f), reach.largest_share * of_objects),
            "objects fill a small share of a surface's view"};
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.irradiance_change = &stage_.Influence().Change();
  }
};

}  // namespace

const EffectDefinition kColourBleedingEffect{
    .name = "colour-bleeding",
    .help = "light that virtual objects reflect to real surfaces",
    .rms_share = 0.016,
    .make = MakeEffect<ColourBleeding>};

}  // namespace pleinair
