// Light on virtual objects that varies over them; without this effect it is computed at a single
// probe among them.
//
// Its bound is an estimate: light at fourteen places around the objects is compared with that at
// the probe (SingleProbeLight), and the difference multiplied by a margin.
#include <optional>

#include <glm/common.hpp>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_of_facings.h"
#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

class LocalLight : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  EffectSwitch SwitchFor(EffectSwitch asked) const override {
    if (stage_.Options().object_light.route == ObjectLight::kSingleProbe) return EffectSwitch::kOff;
    return stage_.Light().MayUseSingleProbe() ? asked : EffectSwitch::kOn;
  }
  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (!stage_.Light().MayUseSingleProbe())
      return {kWhiteCode, "light comes from probes or samples"};
    if (!stage_.InView(frame)) {
      // The light that they reflect to surfaces in view is not bounded here.
      return stage_.Reach(frame).largest_share == 0.0f
                 ? Bound{0.0, "no surface near an object in view"}
                 : Bound{kWhiteCode, "objects out of view reflect light"};
    }
    const Bound all = LightOnObjects(stage_, frame);
    if (all.code_values == 0.0) return all;
    // More is visible under any sky, and places need not be compared.
    const std::optional<float> hidden = stage_.Light().LargestHiddenUpTo(kMostHidden);
    if (!hidden) return {kWhiteCode, "objects hide light from themselves"};
    const SingleProbeLight& single_probe =
        stage_.Light().LightAtSingleProbe(frame.basis, frame.lighting);
    // For light between the places that are compared; not proven to be enough.
    constexpr float kMargin = 1.5f;
    const float largest = ChangeOfFacings(
        stage_, frame, *hidden, single_probe, [](const glm::vec3& here, const glm::vec3& there) {
          return kMargin * glm::abs(there - here);
        });
    return {largest, "light differs between places around the objects"};
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override { return kOnLightAtVertices; }
};

}  // namespace

const EffectDefinition kLocalLightEffect{.name = "local-light",
                                         .help =
                                             "each part of an object gets the light at its own "
                                             "place; without: of a single probe for all",
                                         .rms_share = 0.01,
                                         .make = MakeEffect<LocalLight>,
                                         .is_way_of_others = true};

}  // namespace pleinair
