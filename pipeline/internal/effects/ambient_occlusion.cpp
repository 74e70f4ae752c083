// Light that virtual objects hide from themselves and reflect to themselves, and sunlight on the
// ground beside them.
#include <optional>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_of_facings.h"
#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

class AmbientOcclusion : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (!stage_.InView(frame)) {
      return stage_.Reach(frame).largest_share == 0.0f
                 ? Bound{0.0, "no surface near an object in view"}
                 : Bound{kWhiteCode, "objects out of view reflect light"};
    }
    const Bound all = LightOnObjects(stage_, frame);
    if (all.code_values == 0.0) return all;
    if (!IsDark(SunOf(frame.lighting))) return {all.code_values, "sunlight beside objects"};
    const std::optional<float> hidden = stage_.Light().MayUseSingleProbe()
                                            ? stage_.Light().LargestHiddenUpTo(kMostHidden)
                                            : std::nullopt;
    if (!hidden) return {all.code_values, "objects hide light from themselves"};
    const SingleProbeLight& single_probe =
        stage_.Light().LightAtSingleProbe(frame.basis, frame.lighting);
    return {ChangeOfFacings(stage_,
                            frame,
                            *hidden,
                            single_probe,
                            [](const glm::vec3&, const glm::vec3&) { return glm::vec3(0.0f); }),
            "what objects hide from themselves"};
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override { return kOnLightAtVertices; }
};

}  // namespace

const EffectDefinition kAmbientOcclusionEffect{
    .name = "ambient-occlusion",
    .help = "what objects hide of sky and reflected light from themselves, and reflect",
    .rms_share = 0.02,
    .make = MakeEffect<AmbientOcclusion>,
    .is_way_of_others = true};

}  // namespace pleinair
