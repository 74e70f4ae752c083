// Where a sequence's frames may be measured from.
#pragma once

#include <optional>

#include "datasets/sequence.h"
#include "scene/frame.h"
#include "scene/image.h"

namespace pleinair {

// `mask` at another resolution: 255 where all pixels that a new one covers are 255, else 0.
Gray8Image ScaledMask(const Gray8Image& mask, int width_px, int height_px);

// A diffuse mask over the first frame, where it is not one over a survey map.
class SamplingMask {
 public:
  // Keeps `sequence`. Throws std::runtime_error where the mask cannot be read or has another size.
  explicit SamplingMask(const Sequence& sequence);
  // For frames of the first frame's camera, at any resolution. Throws std::runtime_error as
  // ScaledTo. One thread at a time.
  void ApplyTo(Frame& frame) const;

 private:
  std::optional<Gray8Image> mask_;
  mutable Gray8Image scaled_;  // At the size of the last frame.
  const Sequence& sequence_;
};

}  // namespace pleinair
