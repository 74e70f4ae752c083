#include "relight/transport/region_radiosity.h"

#include <algorithm>
#include <vector>

#include "relight/transport/internal/radiosity_solver.h"
#include "relight/transport/internal/region_irradiance.h"

namespace pleinair {
namespace {

// How the solve of a rank's lights ended.
struct Ending {
  int iterations;
  double residual;
  double energy_error;
};

// For all faces and lights: [face * lights + light], as a single rank would have it.
std::vector<glm::vec3> DirectLight(const PatchScene& scene,
                                   const PatchTransport& transport,
                                   const RegionRadiosityOptions& options) {
  const RankShare faces = ShareOf(options.ranks, scene.FaceCount(), internal::kFacesPerGroup);
  const std::vector<float> direct = JoinValues(
      options.ranks,
      internal::RegionIrradiance(scene,
                                 transport.Points(),
                                 {options.regions, options.sky_rays_per_patch, options.seed},
                                 {faces.first, faces.last},
                                 options.solve.progress));
  std::vector<glm::vec3> grey;
  grey.reserve(direct.size());
  for (const float value : direct) grey.emplace_back(value);
  return grey;
}

// The columns [share.first, share.last) of `lights`.
std::vector<glm::vec3> Columns(const std::vector<glm::vec3>& values,
                               std::size_t lights,
                               const RankShare& share) {
  std::vector<glm::vec3> columns;
  columns.reserve(values.size() / lights * (share.last - share.first));
  for (std::size_t row = 0; row < values.size(); row += lights) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(row);
    columns.insert(columns.end(),
                   begin + static_cast<std::ptrdiff_t>(share.first),
                   begin + static_cast<std::ptrdiff_t>(share.last));
  }
  return columns;
}

FaceLights SolveShared(const PatchScene& scene,
                       const PatchTransport& transport,
                       const std::vector<glm::vec3>& direct,
                       const RegionRadiosityOptions& options) {
  const std::size_t lights = options.regions.Count();
  // Lights of one block stop together: cut elsewhere, they would stop at another iteration.
  const RankShare mine = ShareOf(options.ranks, lights, internal::kLightsPerBlock);
  FaceLights solved;
  if (mine.first < mine.last) {
    solved = transport.SolveMany(
        scene, Columns(direct, lights, mine), mine.last - mine.first, options.solve);
  }
  // Ranks' columns follow each other as blocks of complete lights; they go back among the rows.
  std::vector<glm::vec3> by_light(solved.radiosity.size());
  const std::size_t faces = scene.FaceCount();
  for (std::size_t face = 0; face < faces; ++face) {
    for (std::size_t light = 0; light < solved.lights; ++light) {
      by_light[light * faces + face] = solved.radiosity[face * solved.lights + light];
    }
  }
  by_light = JoinValues(options.ranks, std::move(by_light));
  FaceLights whole;
  whole.lights = lights;
  whole.radiosity.resize(faces * lights);
  for (std::size_t face = 0; face < faces; ++face) {
    for (std::size_t light = 0; light < lights; ++light) {
      whole.radiosity[face * lights + light] = by_light[light * faces + face];
    }
  }
  const Ending ending{solved.iterations, solved.residual, solved.energy_error};
  for (const Ending& of_rank : JoinValues(options.ranks, std::vector<Ending>{ending})) {
    whole.iterations = std::max(whole.iterations, of_rank.iterations);
    whole.residual = std::max(whole.residual, of_rank.residual);
    whole.energy_error = std::max(whole.energy_error, of_rank.energy_error);
  }
  return whole;
}

}  // namespace

FaceLights SolveRegions(const PatchScene& scene,
                        const PatchTransport& transport,
                        const RegionRadiosityOptions& options) {
  const std::vector<glm::vec3> direct = DirectLight(scene, transport, options);
  return options.ranks == nullptr
             ? transport.SolveMany(scene, direct, options.regions.Count(), options.solve)
             : SolveShared(scene, transport, direct, options);
}

}  // namespace pleinair
