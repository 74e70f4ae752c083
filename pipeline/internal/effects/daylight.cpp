// Direct light from the sky, where it is sampled (grosch-2007, section 7).
#include <algorithm>
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

class DaylightBySamples : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  EffectSwitch SwitchFor(EffectSwitch asked) const override {
    const bool is_sampled = stage_.Options().object_light.daylight == Daylight::kSamples;
    return is_sampled ? asked : EffectSwitch::kOff;
  }
  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    const glm::vec3 irradiance = stage_.Light().LargestDaylight(frame.basis, frame.lighting);
    if (IsDark(irradiance)) return {0.0, "no daylight through windows"};
    // One reflection off an object.
    const glm::vec3 of_objects = stage_.LargestAlbedo() * irradiance;
    double codes = 0.0;
    if (stage_.InView(frame)) {
      codes = frame.codes.LargestRise(glm::vec3(0.0f),
                                      kInvPi * stage_.LargestAlbedo() * (irradiance + of_objects));
    }
    const InfluenceReach& reach = stage_.Reach(frame);
    if (reach.largest_share > 0.0f) {
      codes = std::max(codes,
                       ChangeOfReached(frame, reach, irradiance, reach.largest_share * of_objects));
    }
    return {codes, "all light through windows onto the objects"};
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override {
    return kOnLightAtVertices.Without(Effect::kDaylight);
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(WorkOf("daylight samples", frame.light.daylight, frame, {Effect::kDaylight}));
    works.back().ms = frame.light.daylight_made_ms;
    works.back().make = [this, &frame](EffectSet) { stage_.Light().UpdateDaylight(frame.basis); };
  }
};

}  // namespace

// Its rms share is the sun's: daylight is to a room what the sun is outdoors.
const EffectDefinition kDaylightEffect{
    .name = "daylight",
    .help = "light through windows by samples of the sky, with setting daylight=samples",
    .rms_share = 0.2,
    .make = MakeEffect<DaylightBySamples>};

}  // namespace pleinair
