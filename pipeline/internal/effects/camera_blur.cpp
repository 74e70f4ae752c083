// Blurs virtual objects as the camera blurs what it sees.
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {
namespace {

class CameraBlur : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  EffectSwitch SwitchFor(EffectSwitch asked) const override {
    return stage_.Options().camera_matching.blur ? asked : EffectSwitch::kOff;
  }
  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (!(frame.camera_blur_px > 0.0)) return {0.0, "no blur found in the picture"};
    return {kWhiteCode, "edges as soft as the picture's"};
  }
  // Shadows of objects out of view may still be in view.
  EffectSet PartOf(const EffectFrame& frame) override {
    return stage_.InView(frame) ? EffectSet() : EffectSet{Effect::kSunShadow};
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(DrawingOf("draw blur", kDrawMs, frame, {Effect::kCameraBlur}));
  }

  void Draw(const EffectFrame& frame, CompositeInput& input) const override {
    input.camera_blur_px = static_cast<float>(frame.camera_blur_px);
  }

 private:
  static constexpr double kDrawMs = 1.0;  // Nominal, of the objects' layer: see kDrawObjectsMs.
};

}  // namespace

const EffectDefinition kCameraBlurEffect{.name = "camera-blur",
                                         .help = "objects as soft as the picture's own edges",
                                         .rms_share = 0.01,
                                         .make = MakeEffect<CameraBlur>};

}  // namespace pleinair
