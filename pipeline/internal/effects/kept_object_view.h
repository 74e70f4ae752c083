// The objects, pixel by pixel: kept while neither they nor the camera move.
#pragma once

#include "objects/learned_cost.h"
#include "objects/object_view.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "scene/cached.h"

namespace pleinair {

// One thread at a time.
class KeptObjectView {
 public:
  WorkCost Cost(const EffectFrame& frame) const;
  const ObjectView& Update(const PatchScene& objects, const EffectFrame& frame);

 private:
  Cached<ObjectView, ViewOfPose> view_;
  LearnedCost cost_{2.0};
};

}  // namespace pleinair
