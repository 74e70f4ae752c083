#include "pipeline/internal/frame_effects.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "pipeline/internal/effects/light_on_objects.h"
#include "pipeline/internal/effects/motion_track.h"
#include "pipeline/internal/effects/seen_shade.h"
#include "render/real_sun.h"
#include "scene/half_float.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

// Nominal.
constexpr double kReadBackMs = 0.5;
constexpr double kChooseMs = 0.5;  // Time of the plan's choice.
// Where nothing moves, a budget shares the cost of one-off work among this many frames. Otherwise
// it would never start an effect that is cheap from its second frame on.
constexpr double kFramesThatShare = 30.0;

PlannedWork PlannedOf(const FrameWork& work, EffectSet runs) {
  const WorkOffer& offer = work.offer;
  return {offer.name,
          offer.IsNeededFor(runs),
          offer.is_kept,
          offer.is_drawing,
          offer.expected_ms,
          work.ms};
}

}  // namespace

FrameEffects::FrameEffects(const PreparedScene& scene,
                           const Mesh& phantom,
                           const PosedObjects& objects,
                           Compositor& compositor,
                           const FramePipelineOptions& options)
    : objects_(objects),
      compositor_(compositor),
      options_(options),
      stage_(scene, phantom, options),
      codes_(options.display_response, 1.0),
      camera_matching_(options.camera_matching),
      draw_cost_(1.0),
      read_back_cost_(kReadBackMs),
      plan_cost_(kChooseMs) {
  compositor_.SetPhantom(phantom);
  for (const Effect effect : kAllEffects) {
    effects_[static_cast<std::size_t>(effect)] = DefinitionOf(effect).make(stage_);
  }
  Pose();
  SetEffects(options.effects);
}

void FrameEffects::SetEffects(const EffectSettings& effects) {
  settings_ = effects;
  for (const Effect effect : kAllEffects) {
    settings_[effect] = Of(effect).SwitchFor(settings_[effect]);
  }
}

void FrameEffects::Pose() {
  if (poses_ == objects_.PosesId()) return;
  compositor_.SetObjects(objects_.Objects());
  stage_.Pose(objects_);
  poses_ = objects_.PosesId();
}

void FrameEffects::Expose(const LitFrame& lit) {
  const Frame& frame = lit.frame;
  if (const bool corrects = !lit.response.IsNone(); corrects || has_corrected_codes_) {
    codes_ = DisplayCodes(options_.display_response, 1.0, lit.response);
    has_corrected_codes_ = corrects;
  }
  if (frame.exposure && *frame.exposure > 0.0) {
    codes_.SetExposure(*frame.exposure);
    return;
  }
  if (!chosen_exposure_) chosen_exposure_ = ChosenExposure(frame);
  codes_.SetExposure(*chosen_exposure_);
}

WorkSharing FrameEffects::SharingOf(const LitFrame& lit) const {
  const bool is_still =
      !last_geometry_ || last_geometry_ == ViewOfPose{lit.view.geometry_id, poses_};
  if (!settings_.budget_ms || !is_still) return {};
  return {kFramesThatShare, FramesASun(lit.frame)};
}

double FrameEffects::FramesASun(const Frame& frame) const {
  if (!last_time_ || basis_.SkyIsNewAlone()) return 1.0;
  const double since_last_s =
      std::abs(std::chrono::duration<double>(frame.time - *last_time_).count());
  return std::clamp(options_.bounce_step_s / std::max(since_last_s, 1e-3), 1.0, kFramesThatShare);
}

void FrameEffects::AddOffers(EffectSet effects,
                             const EffectFrame& frame,
                             std::vector<EffectOffer>& offers) {
  for (const Effect effect : kAllEffects) {
    if (!effects.Has(effect)) continue;
    EffectOffer& offer = offers[static_cast<std::size_t>(effect)];
    offer.effect = effect;
    const double usual_share = DefinitionOf(effect).rms_share;
    if (settings_[effect] == EffectSwitch::kOff) {
      offer.why = "off";
    } else {
      const Bound bound = Of(effect).BoundOf(frame, offers);
      offer.bound_code_values = bound.code_values;
      offer.why = bound.why;
    }
    offer.needs_any = Of(effect).PartOf(frame);
    offer.rms_share = Of(effect).RmsShare(frame, usual_share);
  }
}

LightBeforePlan FrameEffects::MakeLight(const VertexLight::Mode& mode, const EffectFrame& frame) {
  const Refresh refresh =
      settings_[Effect::kLightUpdate] == EffectSwitch::kOff ? Refresh::kMissing : Refresh::kStale;
  VertexLight& light = stage_.Light();
  LightBeforePlan before = frame.light;
  Stopwatch watch;
  light.Update(mode, refresh, frame.basis, frame.lighting);
  before.made_ms = watch.LapMs();
  if (mode.with_daylight) light.UpdateDaylight(frame.basis);
  before.daylight_made_ms = watch.LapMs();
  light.Evaluate(frame.basis, frame.lighting);
  before.evaluated_ms = watch.LapMs();
  before.made = mode;
  before.was_updated = refresh == Refresh::kStale;
  before.irradiance = light.Irradiance();
  return before;
}

LightSteps FrameEffects::StepsOf(const Frame& frame) const {
  if (!options_.light_in_steps) return LightSteps::kAll;
  if (!last_time_) return options_.first_in_steps ? LightSteps::kFirst : LightSteps::kAll;
  const double since_last_s = std::chrono::duration<double>(frame.time - *last_time_).count();
  if (!(since_last_s > 0.0 && since_last_s <= MotionTrack::kLongestGapS)) return LightSteps::kAll;
  return poses_ == objects_.PosesId() ? LightSteps::kResting : LightSteps::kMoving;
}

RenderedFrame FrameEffects::Render(const LitFrame& lit) {
  RenderedFrame rendered;
  const LightSteps steps = StepsOf(lit.frame);
  stage_.Light().BeginFrame(steps);
  Pose();
  if (objects_.Objects().empty()) {
    rendered.composite = Draw(lit, InputOf(lit, lit.frame.radiance), rendered.timing_ms);
    rendered.clamped_pixels = ClampToHalf(rendered.composite.radiance);
    return rendered;
  }
  Stopwatch watch;
  const bool is_corrected = !lit.response.IsNone() && lit.frame.codes.has_value();
  if (is_corrected) {
    LightOf(*lit.frame.codes, options_.display_response, lit.response, corrected_radiance_);
  }
  const RgbImage& radiance = is_corrected ? corrected_radiance_ : lit.frame.radiance;
  const double correcting_ms = watch.LapMs();
  EffectFrame frame = Begin(lit, radiance, steps);
  double once_ms = 0.0;  // Part of planning, in the first frames only.
  if (settings_[Effect::kCameraBlur] != EffectSwitch::kOff) {
    Stopwatch measuring;
    frame.camera_blur_px = camera_matching_.BlurPx(lit.frame, lit.view);
    once_ms = measuring.LapMs();
  }
  rendered.camera_blur_px = frame.camera_blur_px;

  // Effects that are sure to run do so at once, as their results make other bounds tighter.
  std::vector<EffectOffer> offers(kEffectCount);
  AddOffers(kDecideOnLight, frame, offers);
  const LikelyLight likely = LikelyLightOf(settings_, offers, frame.light.costs);
  const VertexLight::Mode mode = ModeOfLight(stage_.Light(), likely.effects);
  double planning_ms = watch.LapMs();
  if (likely.is_sure) frame.light = MakeLight(mode, frame);
  watch.LapMs();
  // A budget may have found it in another way than is likely; what follows from that stands.
  frame.light.mode = settings_.budget_ms ? last_light_.value_or(mode) : mode;

  AddOffers(EffectSet::All().Without(kDecideOnLight), frame, offers);
  std::vector<FrameWork> works;
  for (const Effect effect : kAllEffects) Of(effect).AddWorks(frame, works);
  const double drawing_ms = correcting_ms + kDrawObjectsMs * draw_cost_.Ms() + read_back_cost_.Ms();
  std::optional<double> budget_ms;
  if (settings_.budget_ms) {
    budget_ms = *settings_.budget_ms - lit.spent_ms - (planning_ms - once_ms) - plan_cost_.Ms() -
                drawing_ms;
  }
  EffectPlan plan = Plan(offers, works, budget_ms);
  planning_ms += watch.LapMs();

  Do(plan.runs, frame.light, works, rendered.timing_ms);
  rendered.daylight = stage_.Light().TakeDaylightSummary();
  CompositeInput input = InputOf(lit, radiance);
  for (const Effect effect : kAllEffects) {
    if (plan.runs.Has(effect)) Of(effect).Draw(frame, input);
  }
  rendered.composite = Draw(lit, input, rendered.timing_ms);
  rendered.timing_ms.render += correcting_ms;
  for (FrameWork& work : works) {
    if (!work.finish || !work.offer.IsNeededFor(plan.runs)) continue;
    Stopwatch finishing;
    work.finish(rendered.composite);
    work.ms += finishing.LapMs();
  }
  rendered.clamped_pixels = ClampToHalf(rendered.composite.radiance);
  rendered.works.reserve(works.size());
  for (const FrameWork& work : works) rendered.works.push_back(PlannedOf(work, plan.runs));
  rendered.is_light_coarse = IsLightCoarse(plan.runs);
  last_light_ = ModeOfLight(stage_.Light(), plan.runs);
  last_runs_ = plan.runs;
  rendered.plan = plan;
  rendered.planning_ms = planning_ms;
  rendered.expected_drawing_ms = drawing_ms;
  LearnDrawing(works, rendered);
  last_geometry_ = frame.Geometry();
  last_time_ = lit.frame.time;
  last_lighting_ = lit.lighting;
  return rendered;
}

std::optional<LookedAtPlaces> FrameEffects::PlacesLookedAt(const Frame& frame,
                                                           const DirectionalLight& sun) const {
  const auto is_on = [&](Effect effect) { return settings_[effect] != EffectSwitch::kOff; };
  if (objects_.Objects().empty()) return LookedAtPlaces{};
  if (poses_ != objects_.PosesId() || !last_lighting_) return std::nullopt;
  if (is_on(Effect::kGlossyReflection) && stage_.AnyGlossy()) return std::nullopt;
  const MotionBlurOptions& motion_blur = options_.motion_blur;
  const bool may_blur_motion =
      frame.exposure_s.value_or(motion_blur.exposure_s) > 0.0 || motion_blur.readout_s > 0.0;
  if (is_on(Effect::kMotionBlur) && may_blur_motion) return std::nullopt;
  const std::optional<double> blur_px =
      is_on(Effect::kCameraBlur) ? camera_matching_.KnownBlurPx() : 0.0;
  if (!blur_px) return std::nullopt;
  const InfluenceParts parts{is_on(Effect::kSkyOcclusion), is_on(Effect::kColourBleeding)};
  std::optional<std::function<bool(std::int32_t, const glm::vec3&)>> influence;
  if (parts.hidden_light || parts.object_light) {
    // What it changes is only known where it has just been computed.
    const bool has_run = (!parts.hidden_light || last_runs_.Has(Effect::kSkyOcclusion)) &&
                         (!parts.object_light || last_runs_.Has(Effect::kColourBleeding));
    if (!has_run) return std::nullopt;
    influence =
        stage_.Influence().MayChange(stage_.Scene().patches, poses_, *last_lighting_, parts);
    if (!influence) return std::nullopt;
  }
  LookedAtPlaces places;
  places.any_near =
      [shadow = stage_.SunPastObjects().NearShadow(sun), influence, boxes = stage_.ObjectBoxes()](
          std::int32_t side, const glm::vec3& point_m, float reach_m) {
        const auto is_near = [&](const BoundingBox& box) {
          const glm::vec3 nearest_m = glm::clamp(point_m, box.lower_m, box.upper_m);
          return glm::distance(point_m, nearest_m) <= reach_m;
        };
        return shadow(point_m, reach_m) || std::ranges::any_of(boxes, is_near) ||
               (influence && (*influence)(side, point_m));
      };
  // Pixels around one that changes are compared with it, as far as an edge matters.
  constexpr double kBlurReach = 3.0;
  places.margin_px = static_cast<int>(kTrustedEdgeDistancePx) +
                     std::max(kAroundPx, SeenShade::kReachPx) +
                     static_cast<int>(std::ceil(kBlurReach * *blur_px));
  return places;
}

EffectFrame FrameEffects::Begin(const LitFrame& lit, const RgbImage& radiance, LightSteps steps) {
  basis_.Update(lit.view_builder, lit.transport_sun, lit.bounce_sun);
  Expose(lit);
  EffectFrame frame{lit.frame,
                    radiance,
                    lit.response,
                    lit.view,
                    lit.view_builder.PixelSides(),
                    basis_,
                    lit.lighting,
                    codes_,
                    poses_,
                    objects_.Poses(),
                    steps};
  frame.light.costs = CostsOfLight(stage_.Light(), basis_, lit.lighting);
  frame.light.daylight = CostOfDaylight(stage_.Light(), basis_);
  frame.threshold_code_values = settings_.threshold_code_values;
  frame.has_budget = settings_.budget_ms.has_value();
  frame.sharing = SharingOf(lit);
  frame.draw_scale = draw_cost_.Ms();
  return frame;
}

EffectPlan FrameEffects::Plan(std::span<const EffectOffer> offers,
                              std::span<const FrameWork> works,
                              std::optional<double> budget_ms) {
  EffectSettings settings = settings_;
  EffectSwitch& current = settings[Effect::kLightUpdate];
  const EffectOffer& update = offers[static_cast<std::size_t>(Effect::kLightUpdate)];
  // A frame without a budget does not depend on earlier frames.
  if (update.bound_code_values > 0.0 && !budget_ms && current == EffectSwitch::kPlan) {
    current = EffectSwitch::kOn;
  }
  std::vector<WorkOffer> of_works;
  of_works.reserve(works.size());
  for (const FrameWork& work : works) of_works.push_back(work.offer);
  Stopwatch choosing;
  EffectPlan plan = PlanEffects(settings, offers, of_works, budget_ms);
  plan_cost_.Learn(choosing.LapMs());
  return plan;
}

void FrameEffects::Do(EffectSet runs,
                      const LightBeforePlan& light,
                      std::vector<FrameWork>& works,
                      StageTimes& times) {
  const auto timed = [runs](FrameWork& work, const auto& part) {
    if (!part || !work.offer.IsNeededFor(runs)) return 0.0;
    Stopwatch watch;
    part(runs);
    const double ms = watch.LapMs();
    work.ms += ms;
    return ms;
  };
  times.transport = light.made_ms + light.daylight_made_ms;
  times.probes = light.evaluated_ms;
  for (FrameWork& work : works) times.transport += timed(work, work.make);
  for (FrameWork& work : works) times.probes += timed(work, work.sum);
  times.relight = stage_.Light().TakeEnvironmentMs();
  times.probes -= times.relight;
}

CompositeInput FrameEffects::InputOf(const LitFrame& lit, const RgbImage& radiance) const {
  return {
      radiance,
      lit.frame.clipped,
      lit.view,
      lit.lighting,
      stage_.Light().Irradiance(),
      {.sun_shading = false, .sun_shadow = false, .object_shadow = false, .probe_shading = false}};
}

Composite FrameEffects::Draw(const LitFrame& lit, const CompositeInput& input, StageTimes& times) {
  Composite composite = compositor_.Render(input);
  Stopwatch recording;
  if (&input.camera_radiance != &lit.frame.radiance) {
    const RgbImage& recorded = lit.frame.radiance;
    const LensCircle circle = LensCircle::Of(recorded.width, recorded.height);
    tbb::parallel_for(0, recorded.height, [&](int y) {
      for (int x = 0; x < recorded.width; ++x) {
        glm::vec3& pixel = composite.radiance.At(x, y);
        const auto change = static_cast<PixelChange>(composite.change.At(x, y));
        if (change == PixelChange::kNone) {
          pixel = recorded.At(x, y);
          continue;
        }
        const double share = circle.ShareOfCorner({x + 0.5, y + 0.5});
        pixel = Recorded(pixel, lit.response, share);
        if (change != PixelChange::kScaled) continue;
        // What is darker than the veil stays so.
        pixel += recorded.At(x, y) - Recorded(input.camera_radiance.At(x, y), lit.response, share);
        pixel = glm::max(pixel, glm::vec3(0.0f));
      }
    });
  }
  composite.draw_ms += recording.LapMs();
  times.render = composite.draw_ms;
  times.readback = composite.readback_ms;
  return composite;
}

bool FrameEffects::IsLightCoarse(EffectSet runs) {
  const bool is_at_vertices = stage_.Light().UpdatedIn().at == VertexLight::At::kVertices;
  const bool has_influence = runs.Has(Effect::kSkyOcclusion) || runs.Has(Effect::kColourBleeding);
  return (runs.HasAny(kOnLightAtVertices) && is_at_vertices && stage_.Light().FollowsObjects()) ||
         (has_influence && stage_.Influence().IsCoarse());
}

void FrameEffects::LearnDrawing(std::span<const FrameWork> works, const RenderedFrame& rendered) {
  double nominal_ms = kDrawObjectsMs;
  for (const FrameWork& work : works) {
    const bool is_drawn = work.offer.is_drawing && work.offer.IsNeededFor(rendered.plan.runs);
    if (is_drawn) nominal_ms += work.offer.nominal_ms;
  }
  // A frame that shows nothing new draws nothing; for the first one that does shaders are compiled.
  if (rendered.composite.draw_calls > 0 && std::exchange(has_drawn_, true)) {
    draw_cost_.Learn(rendered.composite.draw_ms / nominal_ms);
  }
  read_back_cost_.Learn(rendered.composite.readback_ms);
}

}  // namespace pleinair
