// One frame from the camera's picture to the composite.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>
#include <tl/expected.hpp>

#include "estimation/lighting_filter.h"
#include "estimation/lighting_source.h"
#include "objects/mirror_image.h"
#include "objects/object_influence.h"
#include "objects/object_light_options.h"
#include "objects/posed_objects.h"
#include "objects/soft_sun.h"
#include "pipeline/camera_matching.h"
#include "pipeline/effect_plan.h"
#include "pipeline/frame_view.h"
#include "pipeline/motion_blur_options.h"
#include "pipeline/sun_state.h"
#include "pipeline/unproven_sun.h"
#include "relight/prepared_scene.h"
#include "relight/surface_view_builder.h"
#include "relight/volume/environment_view.h"
#include "relight/volume/irradiance_volume.h"
#include "render/compositor.h"
#include "scene/frame.h"
#include "scene/lat_long.h"
#include "sunmodel/site.h"

namespace pleinair {

class DirectDaylight;
class FrameEffects;

// Set-up of the pipeline.
struct FramePipelineOptions {
  SurfaceViewOptions view;
  // The sun's transport is computed for times on this raster. So it is a pure function of a frame's
  // time, and is kept while the sun has hardly moved: half a step is 0.1 deg. 0: computed for every
  // frame.
  double sun_step_s = 48.0;
  // The same for transport that takes longer and changes less: the sun's bounces, and the sky
  // shapes that turn with it. With a multiple of sun_step_s both are computed for the same frames.
  double bounce_step_s = 240.0;
  // Transport for the raster's next time is computed ahead, on another thread, and a frame does not
  // wait for it. Until it is ready, the last one is used (FrameResult::sun_age_s). For live frames.
  bool sun_ahead = false;
  // Where objects have moved since a frame at most half a second before, light on them and on
  // surfaces around them is coarse (object_light.in_motion, influence.in_motion). Later frames
  // refine it. A picture then depends on those before it: for live frames.
  bool light_in_steps = false;
  // With that, the first frame of all is coarse, too (object_light.in_motion.rays_at_first): for
  // callers that somebody waits for.
  bool first_in_steps = false;
  ObjectLightOptions object_light;
  InfluenceAt influence_at = InfluenceAt::kPixels;
  ObjectInfluenceOptions influence;
  SoftSunOptions soft_sun;
  MirrorImageOptions mirror;
  EffectSettings effects;
  CameraMatchingOptions camera_matching;  // Its false fields switch effects off.
  MotionBlurOptions motion_blur;
  // Response from light to the code values in which the plan counts.
  ResponseCurve display_response = ResponseCurve::Srgb();
  // Pictures are drawn in the light of WithDaylightColours. Not for a source that measures the sky
  // itself, whose colours are real.
  bool daylight_colours = true;
  // None: each frame's own estimate is reported.
  std::optional<LightingFilterOptions> filter = LightingFilterOptions{};
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// Wall time in milliseconds. read and write are the caller's.
struct StageTimes {
  double read = 0.0;
  double transport = 0.0;  // View, the sun's part, and drawing of a new sample set.
  double estimate = 0.0;
  double relight = 0.0;  // Environment map, where the route needs it.
  double probes = 0.0;
  double render = 0.0;  // Drawing, and the camera's response taken out before and put in after it.
  double readback = 0.0;
  double write = 0.0;
};

// A piece of work for a frame's effects.
struct PlannedWork {
  std::string_view name;
  bool is_done = false;  // Some effect needed it.
  bool is_kept = false;  // The last frame's result was used.
  bool is_drawing = false;
  double expected_ms = 0.0;
  double ms = 0.0;  // 0 for drawing, whose parts are not timed separately.
};

// The picture of a frame whose light is known.
struct RenderedFrame {
  Composite composite;
  std::int64_t clamped_pixels = 0;  // Pixels of the composite that ClampToHalf changed.
  EffectPlan plan;                  // Without objects nothing is planned.
  std::vector<PlannedWork> works;
  // Objects move or have just come to rest, or it is the first frame. The frame drawn again at the
  // same time, or some more frames at rest, are finer. Only with light_in_steps.
  bool is_light_coarse = false;
  double camera_blur_px = 0.0;       // Measured in the frames so far; 0 where it is off.
  double planning_ms = 0.0;          // Bounds and plan.
  double expected_drawing_ms = 0.0;  // For objects without effects, read-back included.
  // Where daylight is sampled: of the frame's own sky. maps_drawn is 0 where the last frame's maps
  // were kept.
  std::optional<DirectDaylightSummary> daylight;
  StageTimes timing_ms;
};

// The light of a frame, before anything is drawn.
struct FrameLight {
  SunState sun;
  double sun_age_s = 0.0;  // Since the time that the sun's transport is for.
  ClearSkyExpectation clear_sky;
  LightingEstimate estimate;  // Its lighting is the filter's.
  Lighting raw_lighting;      // The frame's own.
  FilterSpan sun_filter;
  FilterSpan sky_filter;
  std::optional<Lighting> drawn_lighting;  // Where it differs from the estimate's.
  bool is_drawn_without_sun = false;       // See UnprovenSun.

  const Lighting& DrawnLighting() const {
    return drawn_lighting ? *drawn_lighting : estimate.lighting;
  }
};

// Everything that Process returns for a frame.
struct FrameResult : RenderedFrame, FrameLight {};

// A real scene, and the virtual objects in it.
struct CompositedScene {
  const PreparedScene& scene;  // Outlives the pipeline.
  const Mesh& phantom;         // The mesh as given; read during the call only.
  std::optional<Site> site;
  // In world coordinates, metres; none: the composite is the frame.
  std::vector<VirtualObject> objects;
};

// Keeps results from frame to frame where they still hold. One thread at a time.
class FramePipeline {
 public:
  // `compositor` outlives the pipeline; its context is current at each call.
  FramePipeline(CompositedScene scene,
                std::unique_ptr<LightingSource> source,
                Compositor& compositor,
                const FramePipelineOptions& options);
  ~FramePipeline();

  // Estimates the light of a frame and composites it. A frame that fails returns an error; the next
  // one may succeed. `object_poses` as in PosedObjects: results that depend on the objects' places
  // are recomputed where one has moved.
  tl::expected<FrameResult, FrameError> Process(const Frame& frame,
                                                std::span<const glm::dmat4> object_poses = {});

  // Draws the last frame again in its known light, with the present objects, poses and effects.
  tl::expected<FrameResult, FrameError> Redraw(const Frame& frame,
                                               const FrameLight& light,
                                               std::span<const glm::dmat4> object_poses = {});

  // Replaces the objects from the next frame on; the light of real surfaces stays. `phantom` as at
  // construction.
  void SetObjects(std::vector<VirtualObject> objects, const Mesh& phantom);

  // Replaces the options' effects from the next frame on; cached results stay. Throws
  // std::invalid_argument naming field and value.
  void SetEffects(const EffectSettings& effects);

  // For the last frame that was processed: its camera's view, and the samples of its light (see
  // LightingSource). For a camera that moves, a frame has only the pixels that it looks at: this
  // makes the others, as for a new view.
  const SurfaceView& WholeView() { return view_builder_.WholeView(); }
  std::span<const DiffuseSample> Samples() const { return source_->Samples(); }

  // The volume of the last frame that succeeded; empty unless objects get their light from it. Once
  // folded, only the probes that objects need are valid.
  const IrradianceVolume& Volume() const;

  // Radiance of the real light around the view's place in the last frame that succeeded, without
  // the sun's disc; scene-linear, lat-long. `lighting` is that frame's.
  RgbImage EnvironmentRadiance(const EnvironmentView& view, const Lighting& lighting) const;

  // Radiance of the unoccluded sky in the last frame that succeeded, without the sun's disc;
  // scene-linear, lat-long, black below the horizon. `lighting` is that frame's.
  RgbImage SkyRadiance(const Lighting& lighting, LatLongSize size) const;

  // Null where daylight is not sampled.
  const DirectDaylight* Daylight() const;
  // What its samples are restricted to, in one line; empty where daylight is not sampled.
  std::string DaylightNote() const;

 private:
  // Draws a frame whose light is known, and adds to the times.
  void Draw(const Frame& frame, FrameResult& result);
  // The time and sun that the frame's transport is for.
  const TransportTime& TransportOf(const Frame& frame, const SunState& sun);
  void MakeSunAhead(const Frame& frame);
  // The pixels of a new view that the frame will look at; none: any.
  std::optional<ViewPart> PartLookedAt(const Frame& frame);
  void FilterEstimate(FrameResult& result);
  void ChooseDrawnLight(FrameLight& light);

  const PreparedScene& scene_;
  std::optional<Site> site_;
  Compositor& compositor_;
  PosedObjects objects_;
  std::unique_ptr<LightingSource> source_;
  std::optional<LightingFilter> filter_;
  UnprovenSun unproven_sun_;
  FramePipelineOptions options_;
  ScaledClearSky clear_sky_;
  SurfaceViewBuilder view_builder_;
  int frames_in_place_ = 0;                                  // That the camera stands still.
  std::optional<TransportTime> transport_;                   // For the last frame.
  std::vector<std::shared_ptr<const SkyShape>> sky_shapes_;  // The source's basis.
  std::unique_ptr<FrameEffects> effects_;
};

}  // namespace pleinair
