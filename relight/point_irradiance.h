// Daylight at given points, gathered by rays at the points themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/blob_store.h"
#include "relight/progress.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/rank_group.h"
#include "relight/transport/sky_visibility.h"
#include "relight/transport/transport.h"
#include "scene/mesh.h"
#include "scene/sky_regions.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {

// Light straight from sky or sun, light by way of any surface, or both.
enum class LightPart { kDirect, kIndirect, kTotal };

struct PointIrradianceOptions {
  int bounces = kAllBounces;  // Reflections on the way to a point; 0 leaves no indirect light.
  SkyRegions regions{1, 1};
  // Longest edge of patches at a point; it grows by patch_growth_per_m for each metre from the
  // nearest point. 0: as short as kPatchBudget patches allow. Patches have even light:
  // interpolation between their corners has larger errors, as it smears edges.
  double patch_size_m = 0.0;
  double patch_growth_per_m = 0.4;
  // Over the hemisphere of each point and normal, or the sphere of each point. Converged: 65536.
  int rays_per_point = 16384;
  // Over the sky as each point and normal sees it, and as each patch does; shared by the regions,
  // at least one each.
  int sky_rays_per_point = 65536;
  int sky_rays_per_patch = 32768;
  int rays_per_patch = 512;    // For the form factors.
  double ground_albedo = 0.0;  // As PatchOptions has it; 0: no ground is added.
  std::uint64_t seed = 1;

  // Ranks that share the regions' radiosity; see RegionRadiosityOptions. Nothing is stored then.
  RankGroup* ranks = nullptr;

  static constexpr std::size_t kPatchBudget = 16000;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// How the radiosity behind an answer ended.
struct RadiositySummary {
  std::size_t patches = 0;
  std::size_t exposed_faces = 0;
  std::size_t memory_bytes = 0;  // Upper bound, known before the work begins.
  int iterations = 0;
  double residual = 0.0;
  double energy_error = 0.0;
};

// Irradiance is computed for every point with every normal.
struct AskedPoints {
  std::vector<glm::vec3> points_m;
  std::vector<glm::vec3> normals;  // Unit.
};

// Every point with every normal, for one mesh as it is: no ground is added unless options say so. A
// ray that misses the mesh and rises above the horizon is sky; nothing shines from below it.
//
// Accuracy  sharp edges of sunlight on surfaces are resolved at the ray's hit; light that surfaces
//           get from the sky, and from each other, is even within a patch.
class PointIrradiance {
 public:
  // The incident light at one moment, as a function of direction without the sun's disc.
  using SkyRadiance = std::function<glm::vec3(const glm::vec3& direction_enu)>;

  // Radiosities of the regions are kept in `store`, which outlives this; null: not kept.
  // Throws std::invalid_argument for options or a mesh that make no sense, a point that is not
  // finite or a normal that is not unit, naming it by its index.
  PointIrradiance(const Mesh& mesh,
                  AskedPoints asked,
                  const PointIrradianceOptions& options,
                  Progress progress,
                  BlobStore* store = nullptr);

  // Irradiance [(point * normals + normal) * lights + light].
  // Irradiance from unit radiance of each of options.regions: as many lights.
  std::vector<glm::vec3> OfRegions(LightPart part);
  // Irradiance from one sky.
  std::vector<glm::vec3> OfSky(const SkyRadiance& radiance, LightPart part);
  // Irradiance from a disc of unit irradiance normal to its beam.
  std::vector<glm::vec3> OfSun(const glm::dvec3& direction_enu,
                               double angular_radius_rad,
                               LightPart part);

  // The same as coefficients of incident radiance: [point * lights + light]. The normals don't
  // matter.
  std::vector<ShRgb> ShOfRegions(LightPart part);
  std::vector<ShRgb> ShOfSky(const SkyRadiance& radiance, LightPart part);
  std::vector<ShRgb> ShOfSun(const glm::dvec3& direction_enu,
                             double angular_radius_rad,
                             LightPart part);

  // Summary of the last call's radiosity; without indirect light nothing is computed.
  const RadiositySummary& Summary() const { return summary_; }

 private:
  struct Sky;  // One sky of given radiance, or the regions.

  std::vector<glm::vec3> OfSky(const Sky& sky, LightPart part);
  std::vector<ShRgb> ShOfSky(const Sky& sky, LightPart part);
  const PatchTransport& Transport();
  FaceLights Solve(std::span<const glm::vec3> direct, std::size_t lights);
  FaceLights SolveRegions();
  SolveOptions SolveSettings() const;
  void Summarise(const FaceLights& solved);
  FaceLights SolveSky(const Sky& sky);
  std::string KeyOf(const Sky& sky) const;
  std::vector<glm::vec3> FromSurfaces(std::span<const Receiver> receivers,
                                      const FaceLights& lights) const;
  std::vector<glm::vec3> SunByWayOfOneSurface(const glm::dvec3& direction_enu,
                                              double angular_radius_rad) const;
  std::vector<Receiver> Receivers() const;
  GatherOptions PatchGather() const;
  GatherOptions PointGather() const;
  void Report(std::string_view stage, double share) const;

  std::vector<glm::vec3> points_m_;
  std::vector<glm::vec3> normals_;
  PointIrradianceOptions options_;
  Progress progress_;
  BlobStore* store_;
  RadiositySummary summary_;
  PatchScene patches_;
  std::unique_ptr<PatchTransport> transport_;  // Made when first needed.
};

}  // namespace pleinair
