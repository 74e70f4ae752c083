#include "pipeline/internal/effects/kept_mirror.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/real_pixels.h"
#include "scene/stopwatch.h"

namespace pleinair {

LightCost KeptMirror::Cost(const EffectFrame& frame) const {
  const bool is_new = !mirror_.IsOf(RaysFor(frame)) || !mirror_.Kept().has_all_lights;
  const LightsDone none;
  const LightsDone& done = lit_.IsOf({RaysFor(frame), frame.light.mode}) ? lit_.Kept().done : none;
  const std::size_t all = LightsToDo(done, is_new, frame, Refresh::kStale).size();
  const std::size_t lacking = LightsToDo(done, is_new, frame, Refresh::kMissing).size();
  LightCost cost;
  cost.lacking = costs_.Of(is_new, lacking);
  cost.lacking.is_kept = !is_new && all == 0;
  cost.now.is_kept = true;
  if (all > lacking) {
    const auto older = static_cast<double>(all - lacking);
    cost.now.expected_ms = cost.now.sun_ms = older * costs_.light.Ms();
    cost.now.is_kept = false;
    cost.now.nominal_ms = older * costs_.light.NominalMs();
  }
  return cost;
}

void KeptMirror::Update(EffectStage& stage, const EffectFrame& frame, Refresh refresh) {
  const PreparedScene& scene = stage.Scene();
  if (scene.survey && !survey_) survey_.emplace(*scene.survey);
  VertexLight& vertex_light = stage.Light();
  const ObjectView& object_view = stage.ViewOfObjects().Update(stage.Objects(), frame);
  Stopwatch watch;
  Gathered& mirror = mirror_.Get(RaysFor(frame), [&] {
    Gathered gathered{MirrorImage(scene.patches,
                                  stage.Objects(),
                                  object_view,
                                  {survey_ ? &*survey_ : nullptr, &frame.view},
                                  stage.Options().mirror)};
    costs_.gather.Learn(watch.LapMs());
    return gathered;
  });
  LitByLight& lit =
      lit_.Get({RaysFor(frame), vertex_light.UpdatedIn()}, [] { return LitByLight(); });
  const LightsDone& source = vertex_light.Done(vertex_light.UpdatedIn());
  const std::vector<std::size_t> lights =
      LightsToDo(lit, source, !mirror.has_all_lights, frame, refresh);
  if (lights.empty()) return;
  for (const std::size_t light : lights) {
    const std::vector<glm::vec3> object_radiosity =
        vertex_light.ObjectRadiosity(frame.basis, light);
    MirroredBasis of_light;
    of_light.sky = frame.basis.Sky(light);
    of_light.real_radiosity = frame.basis.FaceRadiosity(light);
    of_light.object_radiosity = object_radiosity;
    if (light == 0) of_light.real_direct = frame.basis.DirectIrradiance();
    of_light.sun = frame.basis.BounceSun();
    mirror.image.Fold(light, of_light, scene.patches, stage.Objects());
    NoteLight(frame, light, source, lit);
  }
  mirror.has_all_lights = true;
  costs_.light.Learn(watch.LapMs() / static_cast<double>(lights.size()));
}

void KeptMirror::Evaluate(const EffectFrame& frame) {
  Stopwatch watch;
  const MirrorImage& image = mirror_.Kept().image;
  const std::span<const std::int32_t> sunlit = image.SunlitPixels();
  is_in_shade_.assign(IsDark(SunOf(frame.lighting)) ? 0 : sunlit.size(), 0);
  tbb::parallel_for(std::size_t{0}, is_in_shade_.size(), [&](std::size_t i) {
    const std::optional<bool> is_sunlit = LooksSunlit(frame, static_cast<std::size_t>(sunlit[i]));
    is_in_shade_[i] = is_sunlit.value_or(true) ? 0 : 1;
  });
  image.Evaluate(frame.lighting, is_in_shade_, image_);
  costs_.sum.Learn(watch.LapMs());
}

}  // namespace pleinair
