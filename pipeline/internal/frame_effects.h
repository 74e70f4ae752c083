// From the light of a frame to its composite: bounds, plan, the works that the plan picks, drawing.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "objects/frame_basis.h"
#include "objects/vertex_light.h"
#include "pipeline/display_codes.h"
#include "pipeline/frame_pipeline.h"
#include "pipeline/internal/effect_bounds.h"
#include "pipeline/internal/frame_works.h"
#include "pipeline/internal/kept_effects.h"

namespace pleinair {

// One frame's light is known. References live for the call only.
struct LitFrame {
  const Frame& frame;
  const SurfaceView& view;
  SurfaceViewBuilder& view_builder;       // As of `view`.
  const DirectionalLight& transport_sun;  // What the sun's part is made for.
  double spent_ms = 0.0;                  // On this frame's light, of a budget.
};

class FrameEffects {
 public:
  // As FramePipeline, which outlives this with its options.
  FrameEffects(const PreparedScene& scene,
               const Mesh& phantom,
               const std::vector<VirtualObject>& objects,
               Compositor& compositor,
               const FramePipelineOptions& options);

  // The objects are elsewhere; the same vector.
  void ObjectsMoved();
  void SetEffects(const EffectSettings& effects);
  // What was half done is done anew.
  void Forget();

  // Fills `result`, whose estimate is there, with plan, composite and times.
  void Render(const LitFrame& lit, FrameResult& result);

  const IrradianceVolume& Volume() const { return vertex_light_.Volume(); }
  const DirectDaylight* Daylight() const { return vertex_light_.Daylight(); }

 private:
  // What would stand in for light that is not of this sun and sky.
  struct OlderLight {
    bool is_there = false;
    double sun_gone_on_rad = 0.0;
  };

  void Expose(const Frame& frame);
  // All but daylight's, where light on the objects is found in a way.
  FrameWorkCosts CostsOfWorks(const LitFrame& lit,
                              const Lighting& lighting,
                              const LightCosts& light,
                              const VertexLight::Mode& found) const;
  // Of a budget; without one each frame pays for itself.
  WorkSharing SharingOf(const LitFrame& lit) const;
  std::vector<EffectOffer> OfferEffects(const BoundInput& input,
                                        const Bound& probe_shading,
                                        const Bound& daylight,
                                        const Bound& light_variation,
                                        const Bound& self_occlusion,
                                        const OlderLight& older);
  VertexLight::Mode ModeOfLight(EffectSet runs) const;
  WorkCost CostOfDaylight() const;
  LightCost CostOfLight(const VertexLight::Mode& mode, const Lighting& lighting) const;
  // All but the mirror's.
  LightCosts CostsOfLight(const Lighting& lighting) const;
  // Over how many frames a budget may spread what the next sun makes anew.
  double FramesASun(const Frame& frame) const;
  // What the plan's effects need, besides drawing.
  void Work(const LitFrame& lit,
            const Lighting& lighting,
            bool has_vertex_light,
            FrameResult& result);
  void Draw(const LitFrame& lit, const Lighting& lighting, EffectSet runs, FrameResult& result);
  void Learn(const std::vector<WorkOffer>& works, const FrameResult& result);

  const PreparedScene& scene_;
  const std::vector<VirtualObject>& objects_;
  Compositor& compositor_;
  const FramePipelineOptions& options_;
  EffectSettings settings_;
  const Mesh room_;        // As given, where daylight is sampled.
  RayCaster real_caster_;  // Over the mesh as given: its triangles are fewer than the patches.
  VertexLight vertex_light_;
  SoftSun soft_sun_;
  EffectBounds bounds_;
  DisplayCodes codes_;
  std::optional<double> chosen_exposure_;  // For frames without one.
  // The last frame's view's; none where objects have moved since.
  std::optional<std::uint64_t> last_geometry_version_;
  std::optional<UtcTime> last_time_;
  bool has_rendered_ = false;
  std::optional<VertexLight::Mode> last_light_;  // As the last plan found it.

  FrameBasis basis_;
  KeptObjectView object_view_;
  KeptSunShares sun_shares_;
  KeptInfluence influence_;
  KeptMirror mirror_;
  CameraMatching camera_matching_;
  LearnedCost noise_cost_;
  LearnedCost draw_cost_;  // Over the nominal: no milliseconds, but their ratio.
  bool has_drawn_ = false;
  LearnedCost read_back_cost_;
  LearnedCost plan_cost_;  // Of the choice itself.
};

}  // namespace pleinair
