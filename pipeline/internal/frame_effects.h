// Makes a frame's composite from its light: bounds, plan, the works that the plan picks, drawing.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "objects/frame_basis.h"
#include "objects/learned_cost.h"
#include "objects/posed_objects.h"
#include "pipeline/camera_matching.h"
#include "pipeline/display_codes.h"
#include "pipeline/frame_pipeline.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "relight/view_part.h"
#include "scene/state_id.h"

namespace pleinair {

// One frame's light is known. References live for the call only.
struct LitFrame {
  const Frame& frame;
  const ResponseCorrection& response;  // Of the frame, as light is.
  const SurfaceView& view;
  SurfaceViewBuilder& view_builder;       // As of `view`.
  const DirectionalLight& transport_sun;  // The sun that transport is for.
  const DirectionalLight& bounce_sun;     // And its bounces.
  const Lighting& lighting;               // The light that is drawn.
  double spent_ms = 0.0;                  // On this frame's light, of a budget.
};

class FrameEffects {
 public:
  // As FramePipeline, which outlives this with its options and objects.
  FrameEffects(const PreparedScene& scene,
               const Mesh& phantom,
               const PosedObjects& objects,
               Compositor& compositor,
               const FramePipelineOptions& options);

  void SetEffects(const EffectSettings& effects);

  RenderedFrame Render(const LitFrame& lit);

  // Before a frame of a camera that has moved: what of its view Render will look at. None: any of
  // it. `sun` as in LitFrame::transport_sun.
  std::optional<LookedAtPlaces> PlacesLookedAt(const Frame& frame,
                                               const DirectionalLight& sun) const;

  const IrradianceVolume& Volume() const { return stage_.Light().Volume(); }
  const DirectDaylight* Daylight() const { return stage_.Light().Daylight(); }

 private:
  FrameEffect& Of(Effect effect) { return *effects_[static_cast<std::size_t>(effect)]; }
  // Hands objects that have moved to the stage and the compositor.
  void Pose();
  void Expose(const LitFrame& lit);
  // Decides what counts as motion: what follows it reads the answer.
  LightSteps StepsOf(const Frame& frame) const;
  // How a budget shares costs among frames; without a budget each frame has its own costs.
  WorkSharing SharingOf(const LitFrame& lit) const;
  // Over how many frames a budget may spread the work that each sun requires.
  double FramesASun(const Frame& frame) const;
  EffectFrame Begin(const LitFrame& lit, const RgbImage& radiance, LightSteps steps);
  // Fills in what these effects offer, in the order of the list.
  void AddOffers(EffectSet effects, const EffectFrame& frame, std::vector<EffectOffer>& offers);
  // Light on the objects in that way, before the plan.
  LightBeforePlan MakeLight(const VertexLight::Mode& mode, const EffectFrame& frame);
  EffectPlan Plan(std::span<const EffectOffer> offers,
                  std::span<const FrameWork> works,
                  std::optional<double> budget_ms);
  // The works that the effects in `runs` need, except drawing.
  void Do(EffectSet runs,
          const LightBeforePlan& light,
          std::vector<FrameWork>& works,
          StageTimes& times);
  // Without any effect.
  CompositeInput InputOf(const LitFrame& lit, const RgbImage& radiance) const;
  // The result is what the camera would have recorded.
  Composite Draw(const LitFrame& lit, const CompositeInput& input, StageTimes& times);
  bool IsLightCoarse(EffectSet runs);
  void LearnDrawing(std::span<const FrameWork> works, const RenderedFrame& rendered);

  const PosedObjects& objects_;
  Compositor& compositor_;
  const FramePipelineOptions& options_;
  EffectSettings settings_;
  EffectStage stage_;
  std::array<std::unique_ptr<FrameEffect>, kEffectCount> effects_;  // By Effect.
  FrameBasis basis_;
  DisplayCodes codes_;
  RgbImage corrected_radiance_;  // Light of the last frame that was corrected.
  bool has_corrected_codes_ = false;
  std::optional<double> chosen_exposure_;  // For frames without one.
  CameraMatching camera_matching_;

  StateId poses_;  // In the stage and the compositor.
  std::optional<ViewOfPose> last_geometry_;
  std::optional<UtcTime> last_time_;
  std::optional<VertexLight::Mode> last_light_;  // As the last plan found it.
  std::optional<Lighting> last_lighting_;
  EffectSet last_runs_;
  LearnedCost draw_cost_;  // Over the nominal: no milliseconds, but their ratio.
  bool has_drawn_ = false;
  LearnedCost read_back_cost_;
  LearnedCost plan_cost_;  // Time of the choice itself.
};

}  // namespace pleinair
