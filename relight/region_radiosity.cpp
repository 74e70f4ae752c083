#include "relight/region_radiosity.h"

#include <vector>

#include "relight/internal/region_irradiance.h"

namespace pleinair {

FaceLights SolveRegions(const PatchScene& scene,
                        const PatchTransport& transport,
                        const RegionRadiosityOptions& options) {
  const std::size_t regions = options.regions.Count();
  const std::vector<float> direct = internal::RegionIrradiance(scene,
                                                               transport.Points(),
                                                               options.regions,
                                                               options.sky_rays_per_patch,
                                                               options.seed,
                                                               0,
                                                               scene.FaceCount(),
                                                               options.solve.progress);
  std::vector<glm::vec3> grey;
  grey.reserve(direct.size());
  for (const float value : direct) grey.emplace_back(value);
  return transport.SolveMany(scene, grey, regions, options.solve);
}

}  // namespace pleinair
