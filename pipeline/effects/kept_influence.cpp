#include "pipeline/effects/kept_influence.h"

#include <vector>

#include "pipeline/effects/effect_stage.h"
#include "scene/stopwatch.h"

namespace pleinair {

GatheredFor KeptInfluence::RaysFor(const EffectFrame& frame) const {
  GatheredFor rays{frame.Geometry(), frame.basis.LightCount()};
  if (OnFaces()) rays.place.view = 0;
  return rays;
}

WorkCost KeptInfluence::Cost(const EffectFrame& frame) const {
  const bool is_new = !influence_.IsOf(RaysFor(frame)) || !influence_.Kept().has_all_lights;
  const bool is_lit = lit_.IsOf({RaysFor(frame), frame.light.mode});
  const LightsDone none;
  const LightsDone& done = is_lit ? lit_.Kept().done : none;
  WorkCost cost = costs_.Of(is_new, LightsToDo(done, is_new, frame).size());
  if (OnFaces() && (is_new || !influence_.Kept().seen.IsOf(frame.Geometry()))) {
    cost.expected_ms += see_cost_.Ms();
    cost.nominal_ms += see_cost_.NominalMs();
    cost.is_kept = false;
  }
  return cost;
}

void KeptInfluence::Update(EffectStage& stage, const EffectFrame& frame) {
  const PatchScene& real = stage.Scene().patches;
  const ObjectInfluenceOptions& options = stage.Options().influence;
  VertexLight& vertex_light = stage.Light();
  Stopwatch watch;
  Gathered& gathered = influence_.Get(RaysFor(frame), [&] {
    Gathered made{OnFaces() ? ObjectInfluence(real, stage.Objects(), options)
                            : ObjectInfluence(real, stage.Objects(), frame.view, options),
                  false,
                  {}};
    costs_.gather.Learn(watch.LapMs());
    return made;
  });
  ObjectInfluence& influence = gathered.influence;
  if (OnFaces()) {
    gathered.seen.Get(frame.Geometry(), [&] {
      influence.See(real, frame.view, frame.pixel_faces);
      see_cost_.Learn(watch.LapMs());
      return Seen();
    });
  }
  LitByLight& lit =
      lit_.Get({RaysFor(frame), vertex_light.UpdatedIn()}, [] { return LitByLight(); });
  const LightsDone& source = vertex_light.Done(vertex_light.UpdatedIn());
  const std::vector<std::size_t> lights = LightsToDo(lit, source, !gathered.has_all_lights, frame);
  if (lights.empty()) return;
  const bool has_samples = vertex_light.Daylight() != nullptr;
  const std::vector<Receiver> receivers =
      has_samples ? influence.Receivers() : std::vector<Receiver>();
  for (const std::size_t light : lights) {
    const bool is_sampled = light > 0 && has_samples;
    influence.Fold(light,
                   {is_sampled ? nullptr : frame.basis.Sky(light),
                    frame.basis.FaceRadiosity(light),
                    vertex_light.ObjectRadiosity(frame.basis, light),
                    vertex_light.SampledSkyHiddenFrom(frame.basis, light, receivers)},
                   frame.view);
    NoteLight(frame, light, source, lit);
  }
  gathered.has_all_lights = true;
  costs_.light.Learn(watch.LapMs() / static_cast<double>(lights.size()));
}

void KeptInfluence::Evaluate(const Lighting& lighting, const InfluenceParts& parts) {
  Stopwatch watch;
  influence_.Kept().influence.Evaluate(lighting, parts, change_);
  costs_.sum.Learn(watch.LapMs());
}

}  // namespace pleinair
