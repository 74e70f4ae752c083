#include "pipeline/internal/effects/kept_influence.h"

#include <utility>
#include <vector>

#include "pipeline/internal/effects/effect_stage.h"
#include "scene/stopwatch.h"

namespace pleinair {

GatheredFor KeptInfluence::RaysFor(const EffectFrame& frame) const {
  GatheredFor rays{frame.Geometry(), frame.basis.LightCount()};
  // Of any view.
  if (OnFaces()) rays.place.view = {};
  return rays;
}

bool KeptInfluence::Moves(const EffectStage& stage, const EffectFrame& frame) {
  return (frame.steps == LightSteps::kMoving || frame.steps == LightSteps::kFirst) &&
         stage.Options().influence.in_motion.rays_per_receiver > 0;
}

ObjectInfluence KeptInfluence::Make(const EffectStage& stage,
                                    const EffectFrame& frame,
                                    const ObjectInfluenceOptions& options) const {
  const PatchScene& real = stage.Scene().patches;
  return OnFaces() ? ObjectInfluence::InParts(real, stage.Objects(), options)
                   : ObjectInfluence::InParts(real, stage.Objects(), frame.view, options);
}

void KeptInfluence::Refine(const EffectStage& stage, const EffectFrame& frame, Gathered& gathered) {
  const ObjectInfluenceOptions& options = stage.Options().influence;
  if (!gathered.fine) gathered.fine = Make(stage, frame, options);
  const int receivers = frame.steps == LightSteps::kAll ? 0 : options.in_motion.receivers_at_rest;
  if (!gathered.fine->Cast(stage.Scene().patches, stage.Objects(), receivers)) return;
  gathered = Gathered{std::move(*gathered.fine)};
}

WorkCost KeptInfluence::Cost(const EffectStage& stage, const EffectFrame& frame) const {
  const bool is_of_frame = influence_.IsOf(RaysFor(frame));
  const bool follows = is_of_frame ? influence_.Kept().is_coarse : Moves(stage, frame);
  const bool is_new = !is_of_frame || !influence_.Kept().has_all_lights || follows;
  const bool is_lit = lit_.IsOf({RaysFor(frame), frame.light.mode});
  const LightsDone none;
  const LightsDone& done = is_lit ? lit_.Kept().done : none;
  LightByLightCosts costs = costs_;
  if (follows) costs.gather = motion_cost_;
  WorkCost cost = costs.Of(is_new, LightsToDo(done, is_new, frame).size());
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
  const bool moves = Moves(stage, frame);
  const bool is_new = !influence_.IsOf(RaysFor(frame));
  Gathered& gathered = influence_.Get(RaysFor(frame), [&] {
    Gathered made{Make(stage, frame, moves ? options.InMotion() : options), moves};
    made.influence.Cast(real, stage.Objects(), 0);
    (moves ? motion_cost_ : costs_.gather).Learn(watch.LapMs());
    return made;
  });
  if (!is_new && gathered.is_coarse) {
    Refine(stage, frame, gathered);
    motion_cost_.Learn(watch.LapMs());
  }
  ObjectInfluence& influence = gathered.influence;
  const bool is_new_view = OnFaces() && !gathered.seen.IsOf(frame.Geometry());
  if (OnFaces()) {
    gathered.seen.Get(frame.Geometry(), [&] {
      influence.See(real, frame.view, frame.pixel_faces);
      see_cost_.Learn(watch.LapMs());
      return Seen();
    });
  }
  // A second look: it stands.
  if (!is_new && !is_new_view) influence.FindSpans();
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

std::optional<std::function<bool(std::int32_t, const glm::vec3&)>> KeptInfluence::MayChange(
    const PatchScene& real,
    StateId poses,
    const Lighting& lighting,
    const InfluenceParts& parts) const {
  const Gathered& gathered = influence_.Kept();
  if (!OnFaces() || gathered.is_coarse || !gathered.has_all_lights) return std::nullopt;
  if (!influence_.IsOf({{StateId(), poses}, 1 + lighting.sky.size()})) return std::nullopt;
  return gathered.influence.MayChange(real, lighting, parts);
}

void KeptInfluence::Evaluate(const Lighting& lighting, const InfluenceParts& parts) {
  Stopwatch watch;
  influence_.Kept().influence.Evaluate(lighting, parts, change_);
  costs_.sum.Learn(watch.LapMs());
}

}  // namespace pleinair
