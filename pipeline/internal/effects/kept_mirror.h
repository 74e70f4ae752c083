// The mirror images of glossy objects, kept while neither they, nor the camera, nor their light
// change.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "objects/learned_cost.h"
#include "objects/mirror_image.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "pipeline/internal/effects/light_by_light.h"
#include "pipeline/internal/effects/light_on_objects.h"
#include "relight/survey/survey_look_up.h"
#include "scene/cached.h"

namespace pleinair {

// One thread at a time.
class KeptMirror {
 public:
  LightCost Cost(const EffectFrame& frame) const;
  // As KeptInfluence::Update.
  void Update(EffectStage& stage, const EffectFrame& frame, Refresh refresh);
  // Real surfaces have no sun where the frame's picture shows shade.
  void Evaluate(const EffectFrame& frame);
  const MirroredLight& Image() const { return image_; }
  // The lights of the last Update, for any view and pose.
  const LightsDone& Done() const { return lit_.Kept().done; }

 private:
  struct Gathered {
    MirrorImage image;
    bool has_all_lights = false;  // All have been computed once: their sum is defined.
  };

  static GatheredFor RaysFor(const EffectFrame& frame) {
    return {frame.Geometry(), frame.basis.LightCount()};
  }

  std::optional<SurveyLookUp> survey_;  // For a scene with a survey, once something mirrors it.
  Cached<Gathered, GatheredFor> mirror_;
  Cached<LitByLight, LitFor> lit_;
  std::vector<std::uint8_t> is_in_shade_;  // As MirrorImage::Evaluate's.
  MirroredLight image_;
  LightByLightCosts costs_{LearnedCost(60.0), LearnedCost(8.0), LearnedCost(0.5)};
};

}  // namespace pleinair
