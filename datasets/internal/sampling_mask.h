// Where a sequence's frames may be measured from.
#pragma once

#include <optional>

#include "datasets/sequence.h"
#include "scene/frame.h"
#include "scene/image.h"

namespace pleinair {

// A diffuse mask over the first frame, where it is not one over an environment map.
class SamplingMask {
 public:
  // Keeps `sequence`. Throws std::runtime_error where the mask cannot be read or has another size.
  explicit SamplingMask(const Sequence& sequence);
  // Of frames of the first frame's camera.
  void ApplyTo(Frame& frame) const;

 private:
  std::optional<Gray8Image> mask_;
  const Sequence& sequence_;
};

}  // namespace pleinair
