#include "pipeline/internal/effects/frame_effect.h"

#include <array>

namespace pleinair {

FrameWork WorkOf(std::string_view name,
                 const WorkCost& cost,
                 const EffectFrame& frame,
                 EffectSet for_any) {
  const WorkSharing& sharing = frame.sharing;
  const double expected_ms = cost.expected_ms -
                             cost.once_ms * (1.0 - 1.0 / sharing.frames_that_stand_still) -
                             cost.sun_ms * (1.0 - 1.0 / sharing.frames_a_sun);
  return {.offer = {name, cost.nominal_ms, expected_ms, cost.is_kept, false, for_any}};
}

FrameWork DrawingOf(std::string_view name,
                    double nominal_ms,
                    const EffectFrame& frame,
                    EffectSet for_any) {
  return {.offer = {name, nominal_ms, frame.draw_scale * nominal_ms, false, true, for_any}};
}

EffectSet FrameEffect::PartOf(const EffectFrame& /*frame*/) { return {}; }

double FrameEffect::RmsShare(const EffectFrame& /*frame*/, double usual) { return usual; }

void FrameEffect::AddWorks(const EffectFrame& /*frame*/, std::vector<FrameWork>& /*works*/) {}

void FrameEffect::Draw(const EffectFrame& /*frame*/, CompositeInput& /*input*/) const {}

const EffectDefinition& DefinitionOf(Effect effect) {
#define PLEINAIR_ADDRESS(name) &k##name##Effect,
  static constexpr std::array<const EffectDefinition*, kEffectCount> kDefinitions{
      PLEINAIR_EFFECTS(PLEINAIR_ADDRESS)};
#undef PLEINAIR_ADDRESS
  return *kDefinitions.at(static_cast<std::size_t>(effect));
}

}  // namespace pleinair
