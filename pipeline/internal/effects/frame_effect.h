// What one effect states about a frame before the plan, and does once the plan includes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "objects/frame_basis.h"
#include "objects/vertex_light.h"
#include "pipeline/display_codes.h"
#include "pipeline/effect.h"
#include "pipeline/effect_list.h"
#include "pipeline/effect_plan.h"
#include "pipeline/internal/effects/work_cost.h"
#include "render/compositor.h"
#include "scene/frame.h"
#include "scene/lighting.h"
#include "scene/state_id.h"
#include "scene/surface_view.h"

namespace pleinair {

class EffectStage;  // effect_stage.h

// Where objects are in a view: equal where neither has changed.
struct ViewOfPose {
  StateId view;   // SurfaceView::geometry_id or sun_id.
  StateId poses;  // PosedObjects::PosesId().
  bool operator==(const ViewOfPose&) const = default;
};

// Number of frames that share the cost of one-off results, and of results for each sun.
struct WorkSharing {
  double frames_that_stand_still = 1.0;
  double frames_a_sun = 1.0;
};

// Light on the objects, as far as it is known before the plan.
struct LightBeforePlan {
  // The way in which it will be computed, or is likely to be.
  VertexLight::Mode mode;
  // Before anything was computed.
  LightCosts costs;
  WorkCost daylight;
  // The way in which it has been computed already, and its time.
  std::optional<VertexLight::Mode> made;
  bool was_updated = false;  // For this sun and sky, where it was for older ones.
  double made_ms = 0.0;
  double evaluated_ms = 0.0;  // Its sum over this frame's intensities.
  double daylight_made_ms = 0.0;
  // At the vertices, one list for each object; empty where not computed.
  std::span<const std::vector<glm::vec3>> irradiance;
};

// A frame whose light is known. References live for the call only.
struct EffectFrame {
  const Frame& frame;
  const RgbImage& radiance;            // The frame's light,
  const ResponseCorrection& response;  // and what is recorded of it.
  const SurfaceView& view;
  const Image<std::int32_t>& pixel_faces;  // As in SurfaceViewBuilder.
  const FrameBasis& basis;
  const Lighting& lighting;
  const DisplayCodes& codes;
  StateId poses;                                  // PosedObjects::PosesId().
  std::span<const glm::dmat4> object_poses = {};  // Each one's; see PosedObjects.
  LightSteps steps = LightSteps::kAll;
  LightBeforePlan light = {};
  double camera_blur_px = 0.0;  // As measured.
  // Bounds far above this need no refinement.
  double threshold_code_values = 1.0;
  bool has_budget = false;
  WorkSharing sharing = {};
  double draw_scale = 1.0;  // Time of drawing over its nominal time.

  ViewOfPose Geometry() const { return {view.geometry_id, poses}; }
  ViewOfPose UnderSun() const { return {view.sun_id, poses}; }
};

// What leaving an effect out changes in any pixel, at most, in code values of the 8-bit picture,
// and why. An upper bound (bound_terms.h names exceptions); local-light's is an estimate with a
// margin.
struct Bound {
  double code_values = 0.0;
  std::string_view why;
};

// Effects on real surfaces.
inline constexpr EffectSet kOnSurfaces{
    Effect::kSunShadow, Effect::kSkyOcclusion, Effect::kColourBleeding};

// Nominal times of drawing are for software on two cores (bench/plan_bench.cpp). The object has
// 4000 faces over 4000 pixels at 640x480 and stands on the ground; neither it nor the camera moves.
// This time is for objects without any effect.
inline constexpr double kDrawObjectsMs = 1.0;

// A piece of work as the plan knows it, and how it is done.
struct FrameWork {
  WorkOffer offer;
  // Computes what holds while light and geometry do not change. Empty for drawing.
  std::function<void(EffectSet runs)> make = nullptr;
  // Follows when all works are done: sums over this frame's intensities. May be empty.
  std::function<void(EffectSet runs)> sum = nullptr;
  // Changes to the finished composite. May be empty.
  std::function<void(Composite& composite)> finish = nullptr;
  double ms = 0.0;  // Measured; the parts of drawing are not timed separately.
};

// A work that `for_any` of the effects need; `cost` as a budget shares it.
FrameWork WorkOf(std::string_view name,
                 const WorkCost& cost,
                 const EffectFrame& frame,
                 EffectSet for_any);
// The compositor's drawing for them.
FrameWork DrawingOf(std::string_view name,
                    double nominal_ms,
                    const EffectFrame& frame,
                    EffectSet for_any);

// One effect of one pipeline. Keeps what its works may keep from frame to frame.
class FrameEffect {
 public:
  explicit FrameEffect(EffectStage& stage) : stage_(stage) {}
  virtual ~FrameEffect() = default;

  // The switch's value where there is nothing to simulate, or no way to leave the effect out.
  virtual EffectSwitch SwitchFor(EffectSwitch asked) const { return asked; }

  // Returns the bound of the change in any pixel by leaving it out. `before` has the offers of the
  // effects before it in the list, with a bound of 0 for those that are off. Not called for an
  // effect that is off.
  virtual Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> before) = 0;
  // The effects that it is part of: see EffectOffer.
  virtual EffectSet PartOf(const EffectFrame& frame);
  // See EffectOffer; `usual` is the definition's.
  virtual double RmsShare(const EffectFrame& frame, double usual);

  // Adds its own works to those of the frame, in the order in which they are done.
  virtual void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works);

  // Adds its results to the compositor's input; called only where it is run.
  virtual void Draw(const EffectFrame& frame, CompositeInput& input) const;

 protected:
  EffectStage& stage_;
};

// An effect as it is listed.
struct EffectDefinition {
  std::string_view name;  // As on the command line and in plan.jsonl.
  std::string_view help;  // One line of help.
  // Usual change of a picture without it, as a root mean square over the objects' pixels, over a
  // bound of 255. Measured on recordings (docs/accuracy.md, "A budget").
  double rms_share = 1.0;
  std::unique_ptr<FrameEffect> (*make)(EffectStage& stage) = nullptr;
  EffectSet brings = {};          // See BroughtBy.
  bool is_way_of_others = false;  // See IsWayOfOthers.
};

// For EffectDefinition::make.
template <class Made>
std::unique_ptr<FrameEffect> MakeEffect(EffectStage& stage) {
  return std::make_unique<Made>(stage);
}

#define PLEINAIR_DECLARATION(name) extern const EffectDefinition k##name##Effect;
PLEINAIR_EFFECTS(PLEINAIR_DECLARATION)
#undef PLEINAIR_DECLARATION

// Returns the definition of a listed effect.
const EffectDefinition& DefinitionOf(Effect effect);

}  // namespace pleinair
