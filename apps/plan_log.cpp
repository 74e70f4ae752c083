#include "apps/plan_log.h"

#include <nlohmann/json.hpp>

#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

Json EffectsOf(const EffectPlan& plan, EffectFate fate) {
  Json effects = Json::array();
  for (const PlannedEffect& effect : plan.effects) {
    if (effect.fate != fate) continue;
    effects.push_back({{"effect", NameOf(effect.effect)},
                       {"bound_code_values", effect.bound_code_values},
                       {"expected_cost_ms", effect.expected_ms},
                       {"why", effect.why}});
  }
  return effects;
}

Json NamesOfOff(const EffectPlan& plan) {
  Json names = Json::array();
  for (const PlannedEffect& effect : plan.effects) {
    if (effect.fate == EffectFate::kOff) names.push_back(NameOf(effect.effect));
  }
  return names;
}

// Time that the works and the drawing of the plan's frame took.
double ActualMs(const FrameResult& result) {
  double ms = result.timing_ms.render + result.timing_ms.readback + result.planning_ms;
  for (const PlannedWork& work : result.works) ms += work.ms;
  return ms;
}

Json DrawnLightOf(const FrameResult& result) {
  if (!result.drawn_lighting) return nullptr;
  const glm::dvec3& sun = result.drawn_lighting->sun.irradiance_rgb;
  const glm::dvec3 sky = result.drawn_lighting->SkyIrradianceRgb();
  return {{"sun_irradiance_rgb", {sun.x, sun.y, sun.z}},
          {"sky_irradiance_rgb", {sky.x, sky.y, sky.z}}};
}

}  // namespace

std::string PlanLine(const Frame& frame,
                     const FrameResult& result,
                     const EffectSettings& settings) {
  const EffectPlan& plan = result.plan;
  Json line;
  line["frame"] = frame.index;
  line["time_utc"] = FormatUtcTime(frame.time);
  line["threshold_code_values"] =
      settings.budget_ms ? Json(nullptr) : Json(settings.threshold_code_values);
  line["budget_ms"] = settings.budget_ms ? Json(*settings.budget_ms) : Json(nullptr);
  line["run"] = EffectsOf(plan, EffectFate::kRun);
  line["kept"] = EffectsOf(plan, EffectFate::kKept);
  line["left_out"] = EffectsOf(plan, EffectFate::kLeftOut);
  line["off"] = NamesOfOff(plan);
  line["camera_blur_px"] = result.camera_blur_px;
  line["left_out_code_values"] = plan.left_out_code_values;
  line["left_out_rms_code_values"] = plan.left_out_rms_code_values;
  line["fits_budget"] = settings.budget_ms ? Json(plan.fits_budget) : Json(nullptr);
  line["expected_ms"] = plan.expected_ms + result.expected_drawing_ms;
  line["saved_ms"] = plan.SavedMs();
  line["actual_ms"] = ActualMs(result);
  line["planning_ms"] = result.planning_ms;
  line["draw_calls"] = result.composite.draw_calls;
  line["drawn_light"] = DrawnLightOf(result);
  line["pixels_not_finite"] = frame.defects.not_finite;
  line["pixels_clamped"] = result.clamped_pixels;
  Json& works = line["works"] = Json::array();
  for (const PlannedWork& work : result.works) {
    if (!work.is_done) continue;
    works.push_back({{"work", work.name},
                     {"kept", work.is_kept},
                     {"expected_ms", work.expected_ms},
                     {"ms", work.is_drawing ? Json(nullptr) : Json(work.ms)}});
  }
  return line.dump();
}

}  // namespace pleinair
