// Light gathered at the corners of a scene's faces: receivers that stay while the camera moves.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "relight/patch_scene.h"
#include "relight/transport.h"

namespace pleinair {

// Faces of one plane that meet in a corner share its receiver, which stands in the middle of what
// they have around it: at an inner corner on the corner itself, at the plane's rim a little inside.
class CornerGather {
 public:
  CornerGather(const PatchScene& scene, const GatherOptions& options);

  const std::shared_ptr<const GatheredRays>& Rays() const { return rays_; }
  // Receivers of the three corners of `face`, in the order of its patch's vertices.
  const std::array<std::uint32_t, 3>& ReceiversOf(std::size_t face) const {
    return receivers_[face];
  }

 private:
  std::shared_ptr<const GatheredRays> rays_;
  std::vector<std::array<std::uint32_t, 3>> receivers_;  // Per face.
};

}  // namespace pleinair
