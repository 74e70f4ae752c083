// Frames with the plan against frames with everything on, and effect by effect.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/display_codes.h"
#include "pipeline/frame_pipeline.h"

namespace pleinair {

// Per pixel, in code values of the frame's own exposure.
inline std::vector<float> Differences(const Composite& a,
                                      const Composite& b,
                                      const DisplayCodes& codes) {
  std::vector<float> differences;
  for (std::size_t i = 0; i < a.radiance.pixels.size(); ++i) {
    differences.push_back(codes.Difference(a.radiance.pixels[i], b.radiance.pixels[i]));
  }
  return differences;
}

inline FrameResult ProcessWith(FramePipeline& pipeline,
                               const Frame& frame,
                               const EffectSettings& effects,
                               std::span<const glm::dmat4> poses = {}) {
  pipeline.SetEffects(effects);
  auto result = pipeline.Process(frame, poses);
  if (!result) throw std::runtime_error(result.error().reason);
  return std::move(*result);
}

// The pictures are half floats, or were in part: 2^-11 of 255.
inline constexpr float kHalfRounding = 0.13f;
// Light at two probes comes by different rays: with a thousand or more rays it differs by a
// thousandth, in white and by sRGB.
inline constexpr float kRayNoise = 0.12f;

// A code value, but at a thousandth of the pixels: at edges.
inline void ExpectNothingToBeSeenBetween(const FrameResult& all,
                                         const FrameResult& planned,
                                         const Frame& frame,
                                         const std::string& name) {
  const DisplayCodes codes(ResponseCurve::Srgb(), frame.exposure.value());
  const std::vector<float> change = Differences(all.composite, planned.composite, codes);
  const auto visible = std::count_if(
      change.begin(), change.end(), [](float of_pixel) { return of_pixel > 1.0f + kHalfRounding; });
  EXPECT_LE(static_cast<double>(visible), 0.001 * static_cast<double>(change.size())) << name;
}

// Leaves out one effect after the other, and then what the plan leaves out; returns the planned
// frame.
inline FrameResult ExpectThatBoundsHold(FramePipeline& pipeline,
                                        const Frame& frame,
                                        const std::string& name,
                                        std::span<const glm::dmat4> poses = {}) {
  const DisplayCodes codes(ResponseCurve::Srgb(), frame.exposure.value());
  const FrameResult all = ProcessWith(pipeline, frame, EffectSettings::Everything(), poses);
  for (const PlannedEffect& effect : all.plan.effects) {
    if (effect.fate == EffectFate::kOff) continue;
    EffectSettings without = EffectSettings::Everything();
    without[effect.effect] = EffectSwitch::kOff;
    const FrameResult left_out = ProcessWith(pipeline, frame, without, poses);
    const std::vector<float> change = Differences(all.composite, left_out.composite, codes);
    const float largest = *std::max_element(change.begin(), change.end());
    const float noise = effect.effect == Effect::kLocalLight ? kRayNoise : 0.0f;
    EXPECT_LE(largest, static_cast<float>(effect.bound_code_values) + kHalfRounding + noise)
        << name << ": without " << NameOf(effect.effect) << " (" << effect.why << ")";
  }
  FrameResult planned = ProcessWith(pipeline, frame, EffectSettings(), poses);
  ExpectNothingToBeSeenBetween(all, planned, frame, name);
  EXPECT_LE(planned.plan.left_out_code_values, 1.0) << name;
  EXPECT_LE(planned.composite.draw_calls, all.composite.draw_calls) << name;
  return planned;
}

}  // namespace pleinair
