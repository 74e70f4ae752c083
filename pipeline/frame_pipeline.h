// One frame from the camera's picture to the composite.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "datasets/frame_source.h"
#include "estimation/lighting_filter.h"
#include "estimation/lighting_source.h"
#include "pipeline/camera_matching.h"
#include "pipeline/direct_daylight.h"
#include "pipeline/object_gather.h"
#include "pipeline/object_interreflection.h"
#include "pipeline/posed_objects.h"
#include "pipeline/sun_state.h"
#include "relight/environment_view.h"
#include "relight/irradiance_volume.h"
#include "relight/mirror_image.h"
#include "relight/object_influence.h"
#include "relight/object_view.h"
#include "relight/prepared_scene.h"
#include "relight/soft_sun.h"
#include "relight/surface_view_builder.h"
#include "relight/vertex_irradiance.h"
#include "render/compositor.h"
#include "sunmodel/site.h"

namespace pleinair {

// Where virtual objects get the light from that is not the sun's own.
enum class ObjectLight {
  kGather,       // Rays at their vertices: the accurate one, for objects that stand still.
  kVolume,       // The irradiance volume, operator and maps folded once per sun direction.
  kVolumeByMap,  // The same volume, by an environment map made and pushed through for each frame.
};

// How light straight from the sky reaches virtual objects, and is taken by them from real surfaces.
enum class Daylight {
  kGather,   // As all other light: by the rays, probes or map that ObjectLight says.
  kSamples,  // By samples of the sky: sharp shadows through windows.
};

// Where it is worked out what objects hide and send on real surfaces.
enum class InfluenceAt {
  kPixels,  // Anew for each view.
  kFaces,   // On a lattice over the surfaces, kept while the camera moves.
};

struct FramePipelineOptions {
  SurfaceViewOptions view;
  // The sun's transport is made for times on this raster, so that it is a pure function of a
  // frame's time and is kept while the sun has hardly moved: half a step is 0.1 deg. 0: made for
  // every frame.
  double sun_step_s = 48.0;
  ObjectLight object_light = ObjectLight::kGather;
  GatherOptions object_gather;
  Daylight daylight = Daylight::kGather;
  DirectDaylightOptions direct_daylight;  // For samples, and looked at for them alone.
  InfluenceAt influence_at = InfluenceAt::kPixels;
  ObjectInfluenceOptions influence;
  SoftSunOptions soft_sun;
  MirrorImageOptions mirror;
  CompositeEffects effects;
  CameraMatchingOptions camera_matching;
  // Of the camera that gives code values.
  ResponseCurve display_response = ResponseCurve::Srgb();
  // None: each frame's own estimate is reported.
  std::optional<LightingFilterOptions> filter = LightingFilterOptions{};
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// Wall time in milliseconds. read and write are the caller's.
struct StageTimes {
  double read = 0.0;
  double transport = 0.0;  // View, sun's part, and drawing of a new sample set.
  double estimate = 0.0;
  double relight = 0.0;  // Environment map, where the route needs it.
  double probes = 0.0;
  double render = 0.0;
  double readback = 0.0;
  double write = 0.0;
};

struct FrameResult {
  SunState sun;
  ClearSkyExpectation clear_sky;
  LightingEstimate estimate;  // Its lighting is the filter's.
  Lighting raw_lighting;      // The frame's own.
  FilterSpan sun_filter;
  FilterSpan sky_filter;
  Composite composite;
  // Where daylight comes by samples: of the frame's own sky. Its maps_drawn is 0 where those of the
  // last frame could stay.
  std::optional<DirectDaylightSummary> daylight;
  StageTimes timing_ms;
};

// Keeps what may be kept from frame to frame. One thread at a time.
class FramePipeline {
 public:
  // `scene`, `compositor` outlive the pipeline; the compositor's context is current at each call.
  // `objects` are in world coordinates; none is allowed: then the composite is the frame.
  FramePipeline(const PreparedScene& scene,
                const Mesh& phantom,
                std::optional<Site> site,
                std::vector<VirtualObject> objects,
                std::unique_ptr<LightingSource> source,
                Compositor& compositor,
                const FramePipelineOptions& options);

  // A frame that can't be done is an error of its own; the next one may succeed. `object_poses` as
  // PosedObjects has them: what hangs on where objects are is made anew where one has moved.
  tl::expected<FrameResult, FrameError> Process(const Frame& frame,
                                                std::span<const glm::dmat4> object_poses = {});

  // Of the last frame that succeeded; empty unless objects get their light from it. Folded, it
  // holds the probes that objects need alone; the others are not valid.
  const IrradianceVolume& Volume() const { return volume_; }

  // The real light around the view's place in the last frame that succeeded, without the sun's
  // disc. `lighting` is that frame's.
  RgbImage EnvironmentRadiance(const EnvironmentView& view, const Lighting& lighting) const;

  // What daylight samples are restricted to, in a line; empty without such.
  std::string DaylightNote() const;

 private:
  void FilterEstimate(FrameResult& result);
  void SampleDaylight();
  void PoseObjects(std::span<const glm::dmat4> world_from_given);
  void UpdateBasis(bool new_sun);
  void UpdateVolume();
  void UpdateObjects(const SurfaceView& view);
  void UpdateObjectView(const SurfaceView& view);
  void FoldMirror(std::size_t light, std::span<const glm::vec3> object_radiosity);
  // What ray casting says of the sun's shadows: anew where the view or the sun is.
  void UpdateSunShares(const SurfaceView& view);
  // What rays and probes take sky shape `k` for: black where it is sampled.
  const SkyShape& GatheredSky(std::size_t k) const;
  std::vector<glm::vec3> GatherAtVertices(std::size_t light);
  // Irradiance at the objects' vertices, with what they hide and send each other.
  void SumVertexResponses(const Lighting& lighting);
  // Of the sampled daylight; empty without.
  std::vector<glm::vec3> DirectAtVertices(const Lighting& lighting) const;
  void LightVertices(const IrradianceVolume& volume, const Lighting& lighting);
  void Shade(const Lighting& lighting, StageTimes& times);

  const PreparedScene& scene_;
  std::optional<Site> site_;
  PosedObjects objects_;
  // Since their light was last worked out.
  bool objects_moved_ = true;
  std::unique_ptr<LightingSource> source_;
  std::optional<LightingFilter> filter_;
  Compositor& compositor_;
  FramePipelineOptions options_;
  CameraMatching camera_matching_;
  ScaledClearSky clear_sky_;
  std::vector<std::shared_ptr<const SkyShape>> sky_shapes_;  // The source's basis.
  SurfaceViewBuilder view_builder_;

  DirectionalLight transport_sun_;  // Without an intensity: what the sun's part is made for.
  // What basis_ and folded_ were made for.
  std::optional<std::uint64_t> basis_sun_version_;
  std::vector<std::shared_ptr<const SkyShape>> basis_shapes_;
  std::vector<std::size_t> changed_lights_;  // In this frame; 0 is the sun.
  BasisLights basis_;
  FoldedVolume folded_;
  std::vector<std::uint8_t> needed_probes_;  // By the objects' bounding boxes.
  RgbImage environment_;
  IrradianceVolume volume_;
  std::vector<VertexIrradiance> vertices_;  // Per object; set up with its first volume.
  ObjectInterreflection interreflection_;
  std::unique_ptr<DirectDaylight> daylight_;  // Null where daylight is gathered.
  std::vector<std::vector<glm::vec3>> vertex_irradiance_;
  ObjectGather gather_;  // Set up with the first frame of a pose.
  // Per basis light, all objects' vertices; for gathered light.
  std::vector<std::vector<glm::vec3>> vertex_response_;
  ObjectInfluence influence_;
  std::optional<std::uint64_t> influence_geometry_version_;
  IrradianceChange irradiance_change_;
  Mesh room_;              // As given, where daylight is sampled.
  RayCaster real_caster_;  // Over the mesh as given: its triangles are fewer than the patches.
  std::optional<SoftSun> soft_sun_;
  ObjectView object_view_;
  std::optional<std::uint64_t> object_view_version_;  // The view's, of its geometry.
  SunShares sun_shares_;
  bool has_mirrors_ = false;
  MirrorImage mirror_;
  std::optional<std::uint64_t> mirror_version_;  // The view's, of its geometry.
  MirroredLight mirrored_;
  std::optional<std::uint64_t> sun_shares_version_;  // The view's, of its sun.
};

}  // namespace pleinair
