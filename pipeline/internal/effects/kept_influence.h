// Light that objects hide from real surfaces and reflect to them, kept while neither the objects
// nor their light change. In a frame in which objects have moved it is coarse
// (InfluenceInMotionOptions). In later frames the fine one is gathered, a part in each, and
// replaces it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include <glm/vec3.hpp>

#include "objects/learned_cost.h"
#include "objects/object_influence.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "pipeline/internal/effects/light_by_light.h"
#include "scene/cached.h"
#include "scene/state_id.h"

namespace pleinair {

// One thread at a time.
class KeptInfluence {
 public:
  explicit KeptInfluence(InfluenceAt at) : at_(at) {}

  WorkCost Cost(const EffectStage& stage, const EffectFrame& frame) const;
  // The stage must have computed the lights that shine in the frame. If it had them for an older
  // sun, they are recomputed when the stage's are.
  void Update(EffectStage& stage, const EffectFrame& frame);
  // Whether the result of the last Update is coarse: further steps refine it.
  bool IsCoarse() const { return influence_.Kept().is_coarse; }
  void Evaluate(const Lighting& lighting, const InfluenceParts& parts);
  // As ObjectInfluence::MayChange, for objects in those poses. None where it is not known before
  // the next Update: at pixels, and where that gathers.
  std::optional<std::function<bool(std::int32_t side, const glm::vec3& point_m)>> MayChange(
      const PatchScene& real,
      StateId poses,
      const Lighting& lighting,
      const InfluenceParts& parts) const;
  const IrradianceChange& Change() const { return change_; }

 private:
  struct Seen {};
  struct Gathered {
    ObjectInfluence influence;
    bool is_coarse = false;
    bool has_all_lights = false;            // All have been computed once: their sum is defined.
    std::optional<ObjectInfluence> fine{};  // The replacement of a coarse one, in progress.
    Cached<Seen, ViewOfPose> seen{};        // For receivers on faces: which pixels show them.
  };

  // Whether the frame is one in motion, or the first in steps, and treated as such.
  static bool Moves(const EffectStage& stage, const EffectFrame& frame);
  ObjectInfluence Make(const EffectStage& stage,
                       const EffectFrame& frame,
                       const ObjectInfluenceOptions& options) const;
  // Continues the fine one that replaces a coarse one.
  void Refine(const EffectStage& stage, const EffectFrame& frame, Gathered& gathered);
  bool OnFaces() const { return at_ == InfluenceAt::kFaces; }
  // Receivers on faces stay while the camera moves.
  GatheredFor RaysFor(const EffectFrame& frame) const;

  InfluenceAt at_;
  Cached<Gathered, GatheredFor> influence_;
  Cached<LitByLight, LitFor> lit_;
  IrradianceChange change_;
  LightByLightCosts costs_{LearnedCost(150.0), LearnedCost(2.0), LearnedCost(1.0)};
  LearnedCost motion_cost_{40.0};
  LearnedCost see_cost_{4.0};
};

}  // namespace pleinair
