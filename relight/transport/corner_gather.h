// Light gathered at the corners of a scene's faces: receivers that stay while the camera moves.
#pragma once

#include <memory>

#include "relight/transport/face_lattice.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"

namespace pleinair {

class CornerGather {
 public:
  CornerGather(const PatchScene& scene, const GatherOptions& options);

  const std::shared_ptr<const GatheredRays>& Rays() const { return rays_; }
  // Its receivers are those of Rays(), at the faces' own corners.
  const FaceLattice& Lattice() const { return lattice_; }

 private:
  FaceLattice lattice_;
  std::shared_ptr<const GatheredRays> rays_;
};

}  // namespace pleinair
