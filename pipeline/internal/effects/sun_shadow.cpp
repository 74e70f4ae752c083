// The shadow that virtual objects cast on real surfaces.
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/real_pixels.h"
#include "scene/cached.h"
#include "scene/is_finite.h"

namespace pleinair {
namespace {

// Code values by which a real pixel falls when it loses all of its sun, where objects may hide that
// share of its other light. In the dark a step of light is more codes.
float FallInShadow(const EffectFrame& frame, std::size_t pixel, float hidden_share) {
  const glm::vec3& camera = frame.radiance.pixels[pixel];
  if (!IsFinite(camera)) return 0.0f;
  const PixelLight light = LightOfPixel(frame, pixel);
  const RealPixel state = RealPixelOf(frame, pixel, light);
  const float seen = SunSeenWithout(frame, pixel, state);
  if (seen <= 0.0f) return 0.0f;
  const glm::vec3 before = light.indirect + seen * light.direct;
  const glm::vec3 without =
      state.clipped ? glm::max(camera, kInvPi * frame.view.albedo_rgb.pixels[pixel] * before)
                    : camera;
  glm::vec3 after = without;
  for (int c = 0; c < 3; ++c) {
    if (before[c] > 0.0f) after[c] = without[c] * light.indirect[c] / before[c];
  }
  const glm::vec3 hidden = hidden_share * after;
  return CodesBetween(frame, pixel, without - hidden, after - hidden);
}

class SunShadow : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (IsDark(SunOf(frame.lighting))) return {0.0, "no sun"};
    const SoftSun& soft_sun = stage_.SunPastObjects();
    const std::vector<std::uint32_t>& near_shadow = near_shadow_.Get(
        frame.UnderSun(), [&] { return soft_sun.PixelsNearShadow(frame.view, frame.basis.Sun()); });
    if (near_shadow.empty()) return {0.0, "no shadow in view"};
    // Close to a surface an object hides half of what is over it, and more only where it overhangs.
    constexpr float kHiddenClose = 0.75f;
    const float share = stage_.Reach(frame).largest_share;
    const float hidden_share = share >= InfluenceReach::kDecisive ? kHiddenClose : share;
    // Some pixels first: they may already exceed the threshold.
    const std::size_t step = StepOverFew(near_shadow.size());
    const glm::vec3 to_sun(frame.basis.Sun().direction_enu);
    for (std::size_t i = step / 2; i < near_shadow.size(); i += step) {
      const std::size_t pixel = near_shadow[i];
      if (!(FallInShadow(frame, pixel, hidden_share) > kFarAbove * frame.threshold_code_values))
        continue;
      const glm::vec3 start_m = OffsetFromSurface(frame.view.position_world_m.pixels[pixel],
                                                  frame.view.normal_world.pixels[pixel]);
      if (stage_.Objects().caster.Occluded(start_m, to_sun))
        return {kWhiteCode, "a shadow on a sunlit surface"};
    }
    std::vector<float> falls(near_shadow.size());
    const float largest = LargestOver(near_shadow.size(), [&](std::size_t i) {
      falls[i] = FallInShadow(frame, near_shadow[i], hidden_share);
      return falls[i];
    });
    constexpr double kWorthRays = 0.25;
    if (!(largest > kWorthRays * frame.threshold_code_values)) {
      return {largest, "little sunlight where a shadow may fall"};
    }
    // Shadows are narrower than the boxes around objects.
    constexpr float kUnseen = 1.0f / 64.0f;
    std::vector<std::uint32_t> lit;
    std::vector<float> lit_falls;
    for (std::size_t i = 0; i < near_shadow.size(); ++i) {
      if (!(falls[i] > kUnseen)) continue;
      lit.push_back(near_shadow[i]);
      lit_falls.push_back(falls[i]);
    }
    const std::vector<std::uint8_t> loses = soft_sun.MayLoseSun(frame.view, frame.basis.Sun(), lit);
    float bound = kUnseen;
    for (std::size_t i = 0; i < lit.size(); ++i) {
      if (loses[i] != 0) bound = std::max(bound, lit_falls[i]);
    }
    return {bound,
            bound > kUnseen ? "a shadow on a partly sunlit surface"
                            : "no sunlit surface in view is shaded"};
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    FrameWork volumes = DrawingOf(
        "draw shadow volumes", kDrawMs, frame, {Effect::kSunShadow, Effect::kObjectShadow});
    volumes.offer.without = {Effect::kPenumbra};
    works.push_back(std::move(volumes));
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.effects.sun_shadow = true;
  }

 private:
  Cached<std::vector<std::uint32_t>, ViewOfPose> near_shadow_;  // Pixels.
  static constexpr double kDrawMs = 4.0;  // Nominal, of shadow volumes: see kDrawObjectsMs.
};

}  // namespace

const EffectDefinition kSunShadowEffect{
    .name = "sun-shadow",
    .help = "shadows of virtual objects on real surfaces; brings object-shadow",
    .rms_share = 0.12,
    .make = MakeEffect<SunShadow>,
    .brings = {Effect::kObjectShadow}};

}  // namespace pleinair
