#include "pipeline/internal/effects/light_by_light.h"

#include <algorithm>

namespace pleinair {
namespace {

bool Shines(const Lighting& lighting, std::size_t light) {
  return IntensityOf(lighting, light) != glm::vec3(0.0f);
}

}  // namespace

WorkCost LightByLightCosts::Of(bool is_new, std::size_t lights) const {
  const auto count = static_cast<double>(lights);
  return {(is_new ? gather.Ms() : 0.0) + count * light.Ms() + sum.Ms(),
          (is_new ? gather.NominalMs() : 0.0) + count * light.NominalMs() + sum.NominalMs(),
          !is_new && lights == 0,
          is_new ? gather.Ms() + count * light.Ms() : 0.0,
          is_new ? 0.0 : count * light.Ms()};
}

std::vector<std::size_t> LightsToDo(const LightsDone& done,
                                    bool is_new,
                                    const EffectFrame& frame,
                                    Refresh refresh) {
  if (!is_new) return done.StaleIn(frame.basis, frame.lighting, refresh);
  std::vector<std::size_t> all(frame.basis.LightCount());
  for (std::size_t light = 0; light < all.size(); ++light) all[light] = light;
  return all;
}

std::vector<std::size_t> LightsToDo(const LitByLight& lit,
                                    const LightsDone& source,
                                    bool is_new,
                                    const EffectFrame& frame,
                                    Refresh refresh) {
  std::vector<std::size_t> lights = LightsToDo(lit.done, is_new, frame, refresh);
  for (std::size_t light = 0; light < frame.basis.LightCount(); ++light) {
    const StateId made_from = light < lit.made_from.size() ? lit.made_from[light] : StateId();
    if (!Shines(frame.lighting, light) || made_from == source.ResultId(light)) continue;
    if (std::find(lights.begin(), lights.end(), light) == lights.end()) lights.push_back(light);
  }
  return lights;
}

void NoteLight(const EffectFrame& frame,
               std::size_t light,
               const LightsDone& source,
               LitByLight& lit) {
  lit.made_from.resize(frame.basis.LightCount());
  lit.made_from[light] = source.ResultId(light);
  if (Shines(frame.lighting, light)) lit.done.Done(frame.basis, light);
}

}  // namespace pleinair
