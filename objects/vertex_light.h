// All light at the vertices of virtual objects except the sun's disc, and the light that objects
// reflect: kept while light and objects stand still.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "objects/direct_daylight.h"
#include "objects/frame_basis.h"
#include "objects/internal/vertex_smoothing.h"
#include "objects/learned_cost.h"
#include "objects/light_in_motion.h"
#include "objects/light_steps.h"
#include "objects/near_sunlight.h"
#include "objects/object_gather.h"
#include "objects/object_interreflection.h"
#include "objects/object_light_options.h"
#include "objects/posed_objects.h"
#include "objects/single_probe_light.h"
#include "relight/prepared_scene.h"
#include "relight/volume/irradiance_volume.h"
#include "relight/volume/vertex_irradiance.h"
#include "scene/state_id.h"

namespace pleinair {

class VertexLight {
 public:
  // Where the light that vertices get is computed.
  enum class At {
    kVertices,     // Or at the volume's probes.
    kSingleProbe,  // By rays.
  };

  struct Mode {
    At at = At::kVertices;
    bool with_daylight = false;  // Straight from the sky, where that is sampled.
    // With what objects hide from themselves and reflect, and, at a single probe, with sunlight
    // close to them as each vertex sees it. Rays at vertices always include this.
    bool with_objects = true;
    bool operator==(const Mode&) const = default;
  };

  // `scene`, `room` (the mesh as given) and `options` outlive this.
  VertexLight(const PreparedScene& scene, const Mesh& room, const ObjectLightOptions& options);

  // Begins a frame; `steps` says how much its Update computes. In steps, gathered light follows
  // objects that keep their shape (LightInMotion) until all has been gathered at their present
  // place. A first step gathers with fewer rays, and later steps refine it.
  void BeginFrame(LightSteps steps);
  // Sets where objects are; all light on them has to be computed again.
  void Pose(const PosedObjects& objects);
  // Whether gathered light follows the objects: further steps change it.
  bool FollowsObjects() const { return follows_ || is_coarse_; }

  // All objects' triangles, a group an object. Stays at one address.
  const PatchScene& Objects() const { return interreflection_.Objects(); }
  const IrradianceVolume& Volume() const { return volume_; }
  // Null where daylight is gathered.
  const DirectDaylight* Daylight() const { return daylight_.get(); }

  // Whether a single probe can replace the vertices: all light is gathered by rays.
  bool MayUseSingleProbe() const { return IsGathered() && daylight_ == nullptr; }
  // For the lights that shine in `lighting`, for callers that need to know its error.
  const SingleProbeLight& LightAtSingleProbe(const FrameBasis& basis, const Lighting& lighting);
  // Bound of the irradiance that sampled daylight brings to objects, and that they hide of it.
  glm::vec3 LargestDaylight(const FrameBasis& basis, const Lighting& lighting) const;
  // Whether light at vertices includes what objects hide and reflect, whatever the mode says.
  bool VerticesSeeObjects() const { return IsGathered(); }
  // See ObjectInterreflection.
  std::optional<float> LargestHiddenUpTo(float most) {
    return interreflection_.LargestHiddenUpTo(most);
  }

  // Whether only a sum is left to compute.
  bool IsCurrent(const Mode& mode, const FrameBasis& basis, const Lighting& lighting) const {
    return Done(mode).StaleIn(basis, lighting).empty();
  }
  // Time that Update and Evaluate take.
  struct Costs {
    // For light never computed. Not needed again while no object moves: it then counts as older.
    double once_ms = 0.0;
    double now_ms = 0.0;  // For light of an older sun or sky.
    double sum_ms = 0.0;
  };
  Costs Expected(const Mode& mode, const FrameBasis& basis, const Lighting& lighting) const;
  // Without the cost of a new pose.
  Costs Nominal(const Mode& mode, const FrameBasis& basis, const Lighting& lighting) const;

  // Computes the lights that shine in `lighting`; the functions below return them in that mode.
  void Update(Mode mode, Refresh refresh, const FrameBasis& basis, const Lighting& lighting);
  Mode UpdatedIn() const { return mode_; }
  // The suns and skies for which the light is computed, in a mode.
  const LightsDone& Done(const Mode& mode) const {
    return IsGathered() ? Of(mode).done : folded_done_;  // A volume stands where objects move.
  }
  // Draws samples for skies that are new, where daylight is sampled. Update does so where needed; a
  // separate call measures their cost.
  void UpdateDaylight(const FrameBasis& basis);
  bool IsDaylightCurrent(const FrameBasis& basis) const;
  const LearnedCost& DaylightMs() const { return daylight_cost_; }
  // Summary of the daylight samples; none where daylight is gathered. Its maps_drawn are those
  // since the last call.
  std::optional<DirectDaylightSummary> TakeDaylightSummary();

  // Radiosity of the faces of Objects() per unit of a light that Update was given.
  std::vector<glm::vec3> ObjectRadiosity(const FrameBasis& basis, std::size_t light);
  // The irradiance that real surfaces lose of the sampled sky, per unit of the light. Empty where
  // it is not sampled, or left out.
  std::vector<glm::vec3> SampledSkyHiddenFrom(const FrameBasis& basis,
                                              std::size_t light,
                                              std::span<const Receiver> receivers);

  // Sums the light that reaches the vertices.
  void Evaluate(const FrameBasis& basis, const Lighting& lighting);
  // Milliseconds that environment maps took, where the route needs them, since the last call.
  double TakeEnvironmentMs() { return std::exchange(environment_ms_, 0.0); }
  // One list an object.
  const std::vector<std::vector<glm::vec3>>& Irradiance() const { return irradiance_; }

 private:
  using PerObject = std::vector<std::vector<glm::vec3>>;
  // Responses to lights, by rays: for all objects' vertices.
  struct Responses {
    std::vector<std::vector<glm::vec3>> of_light;
    // The same as pictures show it. Light in motion goes on from what was gathered: from this it
    // would be smoothed again. Empty: as of_light.
    std::vector<std::vector<glm::vec3>> smoothed;
    LightsDone done;
  };

  // Ways of finding light that have responses and a cost of their own.
  static std::size_t WayOf(const Mode& mode) {
    if (mode.at == At::kVertices) return 0;
    return mode.with_objects ? 1 : 2;
  }
  Responses& Of(const Mode& mode) { return responses_[WayOf(mode)]; }
  const Responses& Of(const Mode& mode) const { return responses_[WayOf(mode)]; }
  bool IsGathered() const {
    return options_.route == ObjectLight::kGather || options_.route == ObjectLight::kSingleProbe;
  }
  // Whether rays between objects have yet to be cast, where those at vertices do not meet them.
  bool LacksRaysBetween(const Mode& mode) const;
  // Whether these lights first need sunlight close to the objects to be found.
  bool LooksForSun(const Mode& mode, const std::vector<std::size_t>& lights) const;
  Costs CostsBy(double (LearnedCost::*ms)() const,
                const Mode& mode,
                const FrameBasis& basis,
                const Lighting& lighting) const;
  // Computes the irradiance of daylight samples at vertices, with one reflection off the objects.
  void UpdateDaylightResponses(const FrameBasis& basis);
  bool IsSampled(std::size_t light) const { return light > 0 && daylight_ != nullptr; }
  // The sky as rays and probes see it: black where it is sampled.
  const SkyShape& GatheredSky(const FrameBasis& basis, std::size_t light) const;
  void UpdateVolume(const FrameBasis& basis, std::span<const std::size_t> lights);
  void UpdateGathered(const FrameBasis& basis, std::size_t light);
  // Whether the first light at vertices is one of few rays.
  bool MayStartCoarse() const;
  // Sets smoothing_ up by gather_, which is complete.
  void SmoothThisShape();
  // Sets the smoothed response to a light at vertices.
  void Smooth(std::size_t light);
  // Keeps the light of a coarse start until finer light at the same place replaces it.
  void LeaveCoarse();
  // Keeps the light from where the objects were, to follow them; returns whether it can.
  bool Leave(const std::vector<glm::dmat4>& world_from_given);
  // A step of light that follows the objects. Returns whether more are to come; else all rays have
  // been cast, and lights are still to be computed.
  bool Follow(const FrameBasis& basis, std::span<const std::size_t> lights);
  std::vector<std::size_t> NextParts();
  std::vector<LightInMotion::Gathered> GatherParts(std::span<const std::size_t> parts,
                                                   const FrameBasis& basis,
                                                   std::span<const std::size_t> lights);
  std::vector<glm::vec3> AtSingleProbeWithObjects(const FrameBasis& basis, std::size_t light);
  // Adds what sunlight close to the objects changes at their points, `at_vertices` at the vertices.
  template <class AtVertices>
  void AddNearSunlight(const FrameBasis& basis,
                       const AtVertices& at_vertices,
                       std::vector<glm::vec3>& irradiance);
  // Writes to of_unit_.
  void SpreadOverObjects(const std::vector<glm::vec3>& irradiance);
  // Adds one reflection off the objects.
  std::vector<glm::vec3> WithReflection(std::size_t light, std::vector<glm::vec3> irradiance);
  void SumResponses(const FrameBasis& basis, const Lighting& lighting, PerObject& sum);
  std::vector<glm::vec3> DirectAtVertices(const FrameBasis& basis, const Lighting& lighting);
  void LightVertices(const IrradianceVolume& volume,
                     const FrameBasis& basis,
                     const Lighting& lighting,
                     PerObject& sum);

  const PreparedScene& scene_;
  const Mesh& room_;
  const ObjectLightOptions& options_;
  const std::vector<VirtualObject>* objects_ = nullptr;
  std::vector<glm::dmat4> world_from_given_;
  ObjectInterreflection interreflection_;
  std::unique_ptr<DirectDaylight> daylight_;
  std::vector<std::shared_ptr<const SkyShape>> sampled_shapes_;
  bool daylight_is_new_ = false;
  PerObject irradiance_;
  PerObject of_unit_;  // Scratch, as long.
  Mode mode_;
  StateId objects_sun_id_;              // Of the sun that lit the objects' faces.
  std::array<Responses, 3> responses_;  // By WayOf; by probes without responses.

  // By rays.
  ObjectGather gather_;  // Set up with the first frame of a pose that asks for it.
  std::optional<NearSunlight> near_sunlight_;  // With the first one in the sun.
  VertexSmoothing smoothing_;                  // By the last complete gather.
  // Where the objects were before a motion, until motion_ has started from it.
  struct Left {
    std::optional<ObjectInterreflection> interreflection;  // None: they are where they were.
    ObjectGather gather;
    std::vector<glm::dmat4> world_from_given;
    VerticesByLight irradiance;
    LightsDone done;  // The lights that `irradiance` has.
  };
  LightSteps steps_ = LightSteps::kAll;  // The steps of the present frame.
  bool is_coarse_ = false;  // gather_ and near_sunlight_ have few rays: of a first step.
  bool follows_ = false;  // While the objects move, and until all parts of gather_ have been cast.
  std::optional<Left> left_;
  LightInMotion motion_;
  StateId motion_order_;
  std::vector<bool> has_object_moved_;  // With the last pose.
  std::vector<bool> part_moves_;        // Whether a part of gather_ has vertices of such an object.
  std::size_t next_moved_part_ = 0;
  std::size_t next_other_part_ = 0;
  std::vector<std::optional<NearSunlight>> near_of_part_;
  // Per basis light, all objects' vertices: what is sampled.
  std::vector<std::vector<glm::vec3>> daylight_response_;
  LightsDone daylight_done_;
  SingleProbeLight single_probe_;

  // By probes.
  BasisLights basis_;
  FoldedVolume folded_;
  LightsDone folded_done_;
  std::vector<std::uint8_t> needed_probes_;  // By the objects' bounding boxes.
  RgbImage environment_;
  IrradianceVolume volume_;
  IrradianceVolume volume_of_unit_;         // Scratch.
  std::vector<VertexIrradiance> vertices_;  // Per object; set up with its first volume.

  double environment_ms_ = 0.0;
  LearnedCost set_up_cost_;
  LearnedCost near_cost_;
  std::array<LearnedCost, 3> light_costs_;  // By WayOf.
  LearnedCost between_cost_;                // Cost of the rays between objects.
  LearnedCost follow_cost_;
  LearnedCost daylight_cost_;
  LearnedCost sum_cost_;
};

}  // namespace pleinair
