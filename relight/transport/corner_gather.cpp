#include "relight/transport/corner_gather.h"

#include <vector>

namespace pleinair {

CornerGather::CornerGather(const PatchScene& scene, const GatherOptions& options)
    : lattice_(scene, std::vector<std::uint16_t>(scene.FaceCount(), 1)),
      rays_(std::make_shared<const GatheredRays>(scene, lattice_.Receivers(), options)) {}

}  // namespace pleinair
