// Gives virtual objects the noise of the camera.
#include <vector>

#include "objects/learned_cost.h"
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

class CameraNoiseOnObjects : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  EffectSwitch SwitchFor(EffectSwitch asked) const override {
    return stage_.Options().camera_matching.noise ? asked : EffectSwitch::kOff;
  }
  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (!frame.frame.codes) return {0.0, "linear frames have no noise"};
    return {kWhiteCode, "noise of the frame not yet measured"};
  }
  // Pixels that nothing else changes have the camera's own noise.
  EffectSet PartOf(const EffectFrame& frame) override {
    return stage_.InView(frame) ? EffectSet() : kOnSurfaces;
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(
        WorkOf("camera noise", {cost_.Ms(), cost_.NominalMs()}, frame, {Effect::kCameraNoise}));
    works.back().finish = [this, &frame](Composite& composite) {
      Stopwatch watch;
      matching_.AddNoise(frame.frame, stage_.Options().display_response, composite);
      cost_.Learn(watch.LapMs());
    };
  }

 private:
  CameraMatching matching_{stage_.Options().camera_matching};
  LearnedCost cost_{5.0};  // Cost of measuring a frame's noise and adding it.
};

}  // namespace

const EffectDefinition kCameraNoiseEffect{.name = "camera-noise",
                                          .help = "objects as noisy as 8-bit frames are",
                                          .rms_share = 0.005,
                                          .make = MakeEffect<CameraNoiseOnObjects>};

}  // namespace pleinair
