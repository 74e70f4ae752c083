#include "pipeline/internal/frame_effects.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include <glm/common.hpp>

#include "pipeline/daylight_colours.h"
#include "pipeline/internal/rms_share.h"
#include "scene/half_float.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

// Nominal, as the drawing of works (frame_works.cpp).
constexpr double kDrawObjectsMs = 1.0;
constexpr double kReadBackMs = 0.5;
// Of measuring a frame's noise and adding it.
constexpr double kNoiseMs = 5.0;
constexpr double kChooseMs = 0.5;  // Of the plan's choice.
// Where nothing moves, a budget counts what is made once as shared by so many frames: else a frame
// that could afford an effect ever after would never begin it.
constexpr double kFramesThatShare = 30.0;

void Add(const VertexLight::EvaluationTimes& light, StageTimes& times) {
  times.relight = light.environment_ms;
  times.probes += light.light_ms;
}

glm::vec3 HighestAlbedo(const PreparedScene& scene) {
  glm::vec3 highest(0.0f);
  for (const glm::vec3& albedo : scene.patches.face_albedo_rgb) {
    highest = glm::max(highest, albedo);
  }
  return highest;
}

}  // namespace

FrameEffects::FrameEffects(const PreparedScene& scene,
                           const Mesh& phantom,
                           const std::vector<VirtualObject>& objects,
                           Compositor& compositor,
                           const FramePipelineOptions& options)
    : scene_(scene),
      objects_(objects),
      compositor_(compositor),
      options_(options),
      room_(options.object_light.daylight == Daylight::kSamples ? phantom : Mesh()),
      real_caster_(phantom),
      vertex_light_(scene, room_, options.object_light),
      soft_sun_(real_caster_, vertex_light_.Objects(), options.soft_sun),
      bounds_(real_caster_, vertex_light_.Objects(), soft_sun_, HighestAlbedo(scene)),
      codes_(options.display_response, 1.0),
      influence_(options.influence_at),
      camera_matching_(options.camera_matching),
      noise_cost_(kNoiseMs),
      draw_cost_(1.0),
      read_back_cost_(kReadBackMs),
      plan_cost_(kChooseMs) {
  compositor_.SetPhantom(phantom);
  compositor_.SetObjects(objects_);
  vertex_light_.Pose(objects_);
  bounds_.ObjectsMoved();
  SetEffects(options.effects);
}

void FrameEffects::SetEffects(const EffectSettings& effects) {
  settings_ = effects;
  // What is not there to be simulated.
  if (options_.object_light.daylight != Daylight::kSamples)
    settings_[Effect::kDaylight] = EffectSwitch::kOff;
  EffectSwitch& varies = settings_[Effect::kLightVariation];
  if (!vertex_light_.MayBeAtOnePlace()) varies = EffectSwitch::kOn;
  if (options_.object_light.route == ObjectLight::kOnePlace) varies = EffectSwitch::kOff;
  if (!options_.camera_matching.blur) settings_[Effect::kCameraBlur] = EffectSwitch::kOff;
  if (!options_.camera_matching.noise) settings_[Effect::kCameraNoise] = EffectSwitch::kOff;
  EffectSwitch& mirrors = settings_[Effect::kGlossyReflection];
  if (mirrors == EffectSwitch::kOn && !bounds_.AnyGlossy()) mirrors = EffectSwitch::kPlan;
}

void FrameEffects::ObjectsMoved() {
  last_geometry_version_.reset();
  compositor_.SetObjects(objects_);
  vertex_light_.Pose(objects_);
  bounds_.ObjectsMoved();
  object_view_.Forget();
  sun_shares_.Forget();
  influence_.Forget();
  mirror_.Forget();
}

void FrameEffects::Forget() {
  last_geometry_version_.reset();
  basis_.Forget();
  vertex_light_.Forget();
  bounds_.Forget();
  object_view_.Forget();
  sun_shares_.Forget();
  influence_.Forget();
  mirror_.Forget();
}

void FrameEffects::Expose(const Frame& frame) {
  if (frame.exposure && *frame.exposure > 0.0) {
    codes_.SetExposure(*frame.exposure);
    return;
  }
  // 8-bit frames of unknown exposure are in units of their own [0, 1].
  if (!chosen_exposure_) chosen_exposure_ = frame.codes ? 1.0 : ChosenExposure(frame.radiance);
  codes_.SetExposure(*chosen_exposure_);
}

FrameWorkCosts FrameEffects::CostsOfWorks(const LitFrame& lit,
                                          const Lighting& lighting,
                                          const LightCosts& light,
                                          const VertexLight::Mode& found) const {
  FrameWorkCosts costs;
  costs.light = light;
  costs.influence = influence_.Cost(lit.view, basis_, lighting, found);
  costs.object_view = object_view_.Cost(lit.view);
  costs.sun_on_surfaces = sun_shares_.RealCost(lit.view);
  costs.sun_on_objects = sun_shares_.ObjectCost(lit.view);
  costs.noise = {noise_cost_.Ms(), noise_cost_.NominalMs(), false};
  costs.draw_scale = draw_cost_.Ms();
  return costs;
}

WorkSharing FrameEffects::SharingOf(const LitFrame& lit) const {
  const bool is_still = !has_rendered_ || last_geometry_version_ == lit.view.geometry_version;
  if (!settings_.budget_ms || !is_still) return {};
  return {kFramesThatShare, FramesASun(lit.frame)};
}

std::vector<EffectOffer> FrameEffects::OfferEffects(const BoundInput& input,
                                                    const Bound& probe_shading,
                                                    const Bound& daylight,
                                                    const Bound& light_variation,
                                                    const Bound& self_occlusion,
                                                    const OlderLight& older) {
  std::vector<EffectOffer> offers;
  const auto add = [&](Effect effect, const auto& bound_of, EffectSet needs_any = {}) {
    const Bound bound = settings_[effect] == EffectSwitch::kOff ? Bound{0.0, "off"} : bound_of();
    const double rms_share = effect == Effect::kCurrentLight
                                 ? RmsShareOfOlderLight(older.sun_gone_on_rad)
                                 : RmsShareOf(effect);
    offers.push_back({effect, bound.code_values, needs_any, bound.why, rms_share});
  };
  Bound cast;
  Bound on_objects;
  add(Effect::kSunShading, [&] { return bounds_.SunShading(input); });
  add(Effect::kSunShadow, [&] { return cast = bounds_.SunShadow(input); });
  add(Effect::kObjectShadow,
      [&] { return on_objects = bounds_.ObjectShadow(input); },
      {Effect::kSunShading});
  add(
      Effect::kPenumbra,
      [&] { return cast.code_values > on_objects.code_values ? cast : on_objects; },
      kShadows);
  add(Effect::kProbeShading, [&] { return probe_shading; });
  add(
      Effect::kLightVariation, [&] { return light_variation; }, kOnLightAtVertices);
  add(
      Effect::kSelfOcclusion, [&] { return self_occlusion; }, kOnLightAtVertices);
  add(
      Effect::kCurrentLight,
      [&] {
        return older.is_there ? Bound{kWhiteCode, "made for where the sun was, or another sky"}
                              : Bound{0.0, "all is of this sun and sky"};
      },
      kOnLightAtVertices);
  add(
      Effect::kDaylight, [&] { return daylight; }, kOnLightAtVertices.Without(Effect::kDaylight));
  add(Effect::kSkyOcclusion, [&] { return bounds_.SkyOcclusion(input); });
  add(Effect::kColourBleeding, [&] { return bounds_.ColourBleeding(input); });
  add(Effect::kGlossyReflection, [&] { return bounds_.GlossyReflection(input); });
  const bool in_view = bounds_.InView(input.view);
  add(
      Effect::kCameraBlur,
      [&] { return bounds_.CameraBlur(input); },
      in_view ? EffectSet() : EffectSet{Effect::kSunShadow});
  // Pixels that nothing else changes have the camera's own noise.
  add(
      Effect::kCameraNoise,
      [&] { return bounds_.CameraNoise(input); },
      in_view ? EffectSet() : kOnSurfaces);
  return offers;
}

VertexLight::Mode FrameEffects::ModeOfLight(EffectSet runs) const {
  VertexLight::Mode mode;
  if (!runs.Has(Effect::kLightVariation)) mode.at = VertexLight::At::kOnePlace;
  mode.with_daylight = runs.Has(Effect::kDaylight);
  mode.with_objects = runs.Has(Effect::kSelfOcclusion) ||
                      (mode.at == VertexLight::At::kVertices && vertex_light_.VerticesSeeObjects());
  return mode;
}

LightCost FrameEffects::CostOfLight(const VertexLight::Mode& mode, const Lighting& lighting) const {
  const VertexLight::Costs expected = vertex_light_.Expected(mode, basis_, lighting);
  const VertexLight::Costs nominal = vertex_light_.Nominal(mode, basis_, lighting);
  const bool is_kept = vertex_light_.IsCurrent(mode, basis_, lighting);
  return {{expected.once_ms + expected.sum_ms,
           nominal.once_ms + nominal.sum_ms,
           is_kept,
           expected.once_ms},
          {expected.now_ms, nominal.now_ms, is_kept, 0.0, expected.now_ms}};
}

LightCosts FrameEffects::CostsOfLight(const Lighting& lighting) const {
  using Mode = VertexLight::Mode;
  using At = VertexLight::At;
  LightCosts costs;
  costs.at_vertices = CostOfLight(Mode{.at = At::kVertices, .with_objects = false}, lighting);
  costs.at_one_place = CostOfLight(Mode{.at = At::kOnePlace, .with_objects = true}, lighting);
  costs.alone = CostOfLight(Mode{.at = At::kOnePlace, .with_objects = false}, lighting);
  const LightCost with_objects =
      CostOfLight(Mode{.at = At::kVertices, .with_objects = true}, lighting);
  costs.between.once_ms = with_objects.lacking.once_ms - costs.at_vertices.lacking.once_ms;
  costs.between.expected_ms = costs.between.once_ms;
  costs.between.is_kept = costs.between.once_ms == 0.0;
  costs.between_is_apart = !vertex_light_.VerticesSeeObjects();
  costs.mirror.lacking.is_kept = true;
  return costs;
}

double FrameEffects::FramesASun(const Frame& frame) const {
  if (!last_time_ || basis_.SkyIsNewAlone()) return 1.0;
  const double since_last_s =
      std::abs(std::chrono::duration<double>(frame.time - *last_time_).count());
  return std::clamp(options_.sun_step_s / std::max(since_last_s, 1e-3), 1.0, kFramesThatShare);
}

WorkCost FrameEffects::CostOfDaylight() const {
  if (vertex_light_.IsDaylightCurrent(basis_)) return {.is_kept = true};
  return {vertex_light_.DaylightMs().Ms(), vertex_light_.DaylightMs().NominalMs(), false};
}

void FrameEffects::Render(const LitFrame& lit, FrameResult& result) {
  if (options_.daylight_colours) {
    result.drawn_lighting = WithDaylightColours(result.estimate.lighting);
  }
  const Lighting& lighting =
      result.drawn_lighting ? *result.drawn_lighting : result.estimate.lighting;
  if (objects_.empty()) {
    Draw(lit, lighting, {}, result);
    return;
  }
  Stopwatch watch;
  basis_.Update(lit.view_builder, lit.transport_sun);
  Expose(lit.frame);
  BoundInput input{
      lit.frame, lit.view, basis_, lighting, codes_, {}, 0.0, settings_.threshold_code_values};
  double once_ms = 0.0;  // Of planning, of the first frames alone.
  if (settings_[Effect::kCameraBlur] != EffectSwitch::kOff) {
    Stopwatch measuring;
    result.camera_blur_px = camera_matching_.BlurPx(lit.frame, lit.view);
    once_ms = measuring.LapMs();
  }
  input.camera_blur_px = result.camera_blur_px;

  // What is sure to be run is run at once, as what it brings makes other bounds closer.
  LightCosts costs = CostsOfLight(lighting);
  const Bound probe_shading = bounds_.ProbeShading(input);
  const EffectSwitch varies = settings_[Effect::kLightVariation];
  const Bound light_variation = varies == EffectSwitch::kOff
                                    ? Bound{0.0, "off"}
                                    : bounds_.LightVariation(input, probe_shading, vertex_light_);
  // Where the plan has yet to decide between two lights that look alike, the cheaper one will do.
  const bool at_one = varies == EffectSwitch::kOff ||
                      (varies == EffectSwitch::kPlan &&
                       light_variation.code_values <= settings_.threshold_code_values &&
                       costs.at_one_place.NominalMs() <= costs.at_vertices.NominalMs());
  const EffectSwitch shades = settings_[Effect::kProbeShading];
  const bool is_sure =
      shades == EffectSwitch::kOn || (shades == EffectSwitch::kPlan && !settings_.budget_ms &&
                                      probe_shading.code_values > settings_.threshold_code_values);
  const EffectSwitch sampled = settings_[Effect::kDaylight];
  const Bound daylight =
      sampled == EffectSwitch::kOff ? Bound{0.0, "off"} : bounds_.Daylight(input, vertex_light_);
  // The plan decides; what it will not mind is not made before it has.
  const bool with_daylight =
      sampled == EffectSwitch::kOn ||
      (sampled == EffectSwitch::kPlan && daylight.code_values > settings_.threshold_code_values);
  const EffectSwitch hides = settings_[Effect::kSelfOcclusion];
  const Bound self_occlusion = hides == EffectSwitch::kOff
                                   ? Bound{0.0, "off"}
                                   : bounds_.SelfOcclusion(input, probe_shading, vertex_light_);
  EffectSet likely;
  if (!at_one) likely = likely.With(Effect::kLightVariation);
  if (with_daylight) likely = likely.With(Effect::kDaylight);
  if (hides == EffectSwitch::kOn ||
      (hides == EffectSwitch::kPlan &&
       self_occlusion.code_values > settings_.threshold_code_values)) {
    likely = likely.With(Effect::kSelfOcclusion);
  }
  const VertexLight::Mode light = ModeOfLight(likely);
  result.planning_ms = watch.LapMs();
  const auto upto =
      settings_[Effect::kCurrentLight] == EffectSwitch::kOff ? Upto::kLacking : Upto::kCurrent;
  double vertex_ms = 0.0;
  double daylight_ms = 0.0;
  const WorkCost daylight_cost = CostOfDaylight();
  if (is_sure) {
    vertex_light_.Update(light, upto, basis_, lighting);
    vertex_ms = watch.LapMs();
    if (with_daylight) vertex_light_.UpdateDaylight(basis_);
    daylight_ms = watch.LapMs();
    Add(vertex_light_.Evaluate(basis_, lighting), result.timing_ms);
    vertex_ms += watch.LapMs();
    input.vertex_irradiance = vertex_light_.Irradiance();
  }

  // A budget may have found it in another way than is likely; what hangs on that stands.
  const VertexLight::Mode found = settings_.budget_ms ? last_light_.value_or(light) : light;
  if (bounds_.AnyGlossy()) costs.mirror = mirror_.Cost(lit.view, basis_, lighting, found);
  // Within a budget the plan may choose any way, and says so where that has older light.
  const OlderLight older{
      (settings_.budget_ms ? costs.AnyHasOlder() : costs.Of(found).HasOlder()) ||
          costs.mirror.HasOlder(),
      std::max(vertex_light_.Done(found).SunGoneOnRad(basis_, lighting),
               bounds_.AnyGlossy() ? mirror_.Done().SunGoneOnRad(basis_, lighting) : 0.0)};
  const std::vector<EffectOffer> offers =
      OfferEffects(input, probe_shading, daylight, light_variation, self_occlusion, older);
  FrameWorkCosts work_costs = CostsOfWorks(lit, lighting, costs, found);
  work_costs.daylight = daylight_cost;
  const std::vector<WorkOffer> works = OfferWorks(work_costs, SharingOf(lit));
  result.expected_drawing_ms = kDrawObjectsMs * draw_cost_.Ms() + read_back_cost_.Ms();
  std::optional<double> budget_ms;
  if (settings_.budget_ms) {
    budget_ms = *settings_.budget_ms - lit.spent_ms - (result.planning_ms - once_ms) -
                plan_cost_.Ms() - result.expected_drawing_ms;
  }
  EffectSettings settings = settings_;
  EffectSwitch& current = settings[Effect::kCurrentLight];
  // A frame without a budget is the same whatever was before it.
  if (older.is_there && !budget_ms && current == EffectSwitch::kPlan) current = EffectSwitch::kOn;
  Stopwatch choosing;
  result.plan = PlanEffects(settings, offers, works, budget_ms);
  plan_cost_.Learn(choosing.LapMs());
  result.planning_ms += watch.LapMs();

  result.works.clear();
  for (const WorkOffer& work : works) {
    result.works.push_back({work.name,
                            work.IsNeededFor(result.plan.runs),
                            work.is_kept,
                            work.is_drawing,
                            work.expected_ms,
                            0.0});
  }
  const WorkIndex made_now = LightWork(light, upto);
  const bool made_anew = upto == Upto::kCurrent && works[made_now].nominal_ms > 0.0;
  result.works[made_anew ? made_now : LightWork(light, Upto::kLacking)].ms = vertex_ms;
  result.works[kDaylightSamples].ms = daylight_ms;
  Work(lit, lighting, is_sure && light == ModeOfLight(result.plan.runs), result);
  Draw(lit, lighting, result.plan.runs, result);
  Learn(works, result);
  last_geometry_version_ = lit.view.geometry_version;
  last_time_ = lit.frame.time;
  has_rendered_ = true;
  last_light_ = ModeOfLight(result.plan.runs);
}

void FrameEffects::Work(const LitFrame& lit,
                        const Lighting& lighting,
                        bool has_vertex_light,
                        FrameResult& result) {
  const EffectSet runs = result.plan.runs;
  const SurfaceView& view = lit.view;
  const PatchScene& objects = vertex_light_.Objects();
  StageTimes& times = result.timing_ms;
  const double probes_before_ms = times.probes + times.relight;
  Stopwatch whole;
  const auto timed = [&result](WorkIndex index, const auto& work) {
    Stopwatch watch;
    work();
    result.works[index].ms += watch.LapMs();
  };
  const VertexLight::Mode light = ModeOfLight(runs);
  const WorkIndex light_work = LightWork(light, Upto::kLacking);
  if (runs.HasAny(kOnLightAtVertices)) {
    timed(light_work, [&] { vertex_light_.Update(light, Upto::kLacking, basis_, lighting); });
  }
  if (runs.Has(Effect::kCurrentLight)) {
    timed(LightWork(light, Upto::kCurrent),
          [&] { vertex_light_.Update(light, Upto::kCurrent, basis_, lighting); });
  }
  if (runs.Has(Effect::kDaylight)) {
    timed(kDaylightSamples, [&] { vertex_light_.UpdateDaylight(basis_); });
  }
  if (runs.HasAny(kOnInfluence)) {
    timed(kInfluence, [&] {
      influence_.Update(
          scene_, view, lit.view_builder.PixelFaces(), basis_, lighting, options_, vertex_light_);
    });
  }
  const bool soft = runs.Has(Effect::kPenumbra);
  if (runs.Has(Effect::kGlossyReflection) || (soft && runs.Has(Effect::kObjectShadow))) {
    timed(kObjectView, [&] { object_view_.Update(objects, view); });
  }
  if (runs.Has(Effect::kGlossyReflection)) {
    const auto update_mirror = [&](Upto upto) {
      mirror_.Update(scene_,
                     view,
                     object_view_.View(),
                     basis_,
                     lighting,
                     options_.mirror,
                     upto,
                     vertex_light_);
    };
    timed(kMirrorImage, [&] { update_mirror(Upto::kLacking); });
    if (runs.Has(Effect::kCurrentLight)) {
      timed(kMirrorImageNow, [&] { update_mirror(Upto::kCurrent); });
    }
  }
  if (soft && runs.Has(Effect::kSunShadow)) {
    timed(kSunOnSurfaces, [&] { sun_shares_.UpdateReal(soft_sun_, view, basis_.Sun()); });
  }
  if (soft && runs.Has(Effect::kObjectShadow)) {
    timed(kSunOnObjects,
          [&] { sun_shares_.UpdateObjects(soft_sun_, view, object_view_.View(), basis_.Sun()); });
  }
  times.transport += whole.LapMs();

  if (runs.Has(Effect::kProbeShading) && !has_vertex_light) {
    timed(light_work, [&] { Add(vertex_light_.Evaluate(basis_, lighting), times); });
  }
  if (runs.Has(Effect::kGlossyReflection)) {
    timed(kMirrorImage, [&] { mirror_.Evaluate(lighting); });
  }
  if (runs.HasAny(kOnInfluence)) {
    timed(kInfluence, [&] {
      influence_.Evaluate(lighting,
                          {.hidden_light = runs.Has(Effect::kSkyOcclusion),
                           .object_light = runs.Has(Effect::kColourBleeding)});
    });
  }
  times.probes = probes_before_ms - times.relight + whole.LapMs();
  result.daylight = vertex_light_.TakeDaylightSummary();
}

void FrameEffects::Draw(const LitFrame& lit,
                        const Lighting& lighting,
                        EffectSet runs,
                        FrameResult& result) {
  result.composite = compositor_.Render(
      {lit.frame.radiance,
       lit.frame.clipped,
       lit.view,
       lighting,
       vertex_light_.Irradiance(),
       {.sun_shading = runs.Has(Effect::kSunShading),
        .sun_shadow = runs.Has(Effect::kSunShadow),
        .object_shadow = runs.Has(Effect::kObjectShadow),
        .probe_shading = runs.Has(Effect::kProbeShading)},
       runs.HasAny(kOnInfluence) ? &influence_.Change() : nullptr,
       runs.Has(Effect::kPenumbra) ? &sun_shares_.Shares() : nullptr,
       runs.Has(Effect::kGlossyReflection) ? &mirror_.Image() : nullptr,
       runs.Has(Effect::kCameraBlur) ? static_cast<float>(result.camera_blur_px) : 0.0f});
  result.timing_ms.render = result.composite.draw_ms;
  result.timing_ms.readback = result.composite.readback_ms;
  if (runs.Has(Effect::kCameraNoise)) {
    Stopwatch watch;
    camera_matching_.AddNoise(lit.frame, options_.display_response, result.composite);
    result.works[kNoise].ms = watch.LapMs();
    noise_cost_.Learn(result.works[kNoise].ms);
  }
  result.clamped_pixels = ClampToHalf(result.composite.radiance);
}

void FrameEffects::Learn(const std::vector<WorkOffer>& works, const FrameResult& result) {
  double nominal_ms = kDrawObjectsMs;
  for (const WorkOffer& work : works) {
    if (work.is_drawing && work.IsNeededFor(result.plan.runs)) nominal_ms += work.nominal_ms;
  }
  // A frame that shows nothing new draws nothing; for the first one that does shaders are compiled.
  if (result.composite.draw_calls > 0 && std::exchange(has_drawn_, true)) {
    draw_cost_.Learn(result.composite.draw_ms / nominal_ms);
  }
  read_back_cost_.Learn(result.composite.readback_ms);
}

}  // namespace pleinair
