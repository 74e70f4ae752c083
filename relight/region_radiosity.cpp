#include "relight/region_radiosity.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "relight/sky_visibility.h"

namespace pleinair {

FaceLights SolveRegions(const PatchScene& scene,
                        const PatchTransport& transport,
                        const RegionRadiosityOptions& options) {
  const std::size_t regions = options.regions.Count();
  const int per_region = std::max(1, options.sky_rays_per_patch / static_cast<int>(regions));
  const auto directions =
      std::make_shared<SkyDirections>(options.regions, per_region, options.seed);
  const std::vector<float> direct =
      SkyVisibility::OfFaces(scene, transport.Points(), directions).FromRegions();
  std::vector<glm::vec3> grey;
  grey.reserve(direct.size());
  for (const float value : direct) grey.emplace_back(value);
  return transport.SolveMany(scene, grey, regions, options.solve);
}

}  // namespace pleinair
