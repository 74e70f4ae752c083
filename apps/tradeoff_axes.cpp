#include "apps/tradeoff_axes.h"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "session/settings.h"

namespace pleinair {
namespace {

using Judge = SweepAxis::Judge;
using Texts = std::vector<std::string>;

const std::string kSamplesOfSky = "pipeline.object_light.direct_daylight.sampling.samples";

// With the setting's own default.
SweepAxis AxisOf(const std::string& setting,
                 Judge judge,
                 const Texts& values,
                 Texts depends_on = {}) {
  SweepAxis axis{setting, std::move(depends_on), judge, false, {}, SettingOf(setting).standard};
  for (const std::string& text : values) {
    SweepValue& value = axis.values.emplace_back(SweepValue{text, axis.depends_on, std::nullopt});
    value.assignments.push_back(fmt::format("{}={}", setting, text));
  }
  return axis;
}

SweepAxis WithDefault(SweepAxis axis, std::string text) {
  axis.default_text = std::move(text);
  return axis;
}

SweepAxis WithRaysBySeed(SweepAxis axis) {
  axis.rays_by_seed = true;
  return axis;
}

// With another value before the others, by which the default is stated where `is_default`.
SweepAxis WithValue(SweepAxis axis, SweepValue value, bool is_default) {
  if (is_default) axis.default_text = value.text;
  axis.values.insert(axis.values.begin(), std::move(value));
  return axis;
}

void AddLightAxes(std::vector<SweepAxis>& axes) {
  const Texts samples{"25", "50", "100", "200", "500", "1000", "2000", "4000", "8000"};
  axes.push_back(AxisOf("light.samples", Judge::kEstimate, samples));
  axes.push_back(AxisOf("light.choice", Judge::kEstimate, {"balanced", "proportional", "random"}));
  axes.push_back(AxisOf("light.fit.loss", Judge::kEstimate, {"tukey", "huber", "squares"}));
  axes.push_back(AxisOf("light.fit.solver", Judge::kEstimate, {"ceres", "closed"}));
  axes.push_back(AxisOf("light.sky_shapes",
                        Judge::kTransport,
                        {"uniform",
                         "overcast",
                         "clear",
                         "uniform,overcast",
                         "uniform,clear",
                         "overcast,clear",
                         "uniform,overcast,clear"}));
  axes.push_back(AxisOf("prepare.bounces", Judge::kTransport, {"0", "1", "2", "all"}));
}

void AddPreparedAxes(const SweepCase& sweep_case, std::vector<SweepAxis>& axes) {
  const Judge judge = sweep_case.light_is_fitted ? Judge::kTransport : Judge::kPicture;
  axes.push_back(WithRaysBySeed(AxisOf("prepare.rays", judge, {"16", "64", "256", "512"})));
  const Texts sides_m =
      sweep_case.is_indoors ? Texts{"2", "1", "0.5", "0.25", "0.125"} : Texts{"4", "2", "1", "0.5"};
  axes.push_back(WithDefault(WithRaysBySeed(AxisOf("prepare.patch_size_m", judge, sides_m)),
                             sweep_case.is_indoors ? "0.25" : "0.5"));
}

void AddProbeAxes(const SweepCase& sweep_case, std::vector<SweepAxis>& axes) {
  const std::string route = "pipeline.object_light.route=";
  axes.push_back(AxisOf("pipeline.object_light.single_probe.sh_bands",
                        Judge::kPicture,
                        {"1", "2", "3", "5", "7", "10"},
                        {route + "probe"}));
  axes.push_back(AxisOf("prepare.probe_counts",
                        Judge::kPicture,
                        {"1x1x1", "2x2x2", "4x4x4", "8x8x8", "16x16x16"},
                        {route + "volume"}));
  axes.push_back(WithRaysBySeed(AxisOf(
      "prepare.probe_rays", Judge::kPicture, {"64", "256", "1024", "4096"}, {route + "volume"})));
  Texts widths;
  for (const int part : {16, 8, 4, 2, 1}) {
    if (sweep_case.map_width % part != 0) continue;
    widths.push_back(std::to_string(sweep_case.map_width / part));
  }
  if (sweep_case.map_width > 0) {
    axes.push_back(
        WithDefault(AxisOf("prepare.map_width", Judge::kPicture, widths, {route + "map"}),
                    std::to_string(sweep_case.map_width)));
  }
}

void AddPictureAxes(const SweepCase& sweep_case, std::vector<SweepAxis>& axes) {
  const bool on_surfaces = sweep_case.receivers_at == SurfaceViewOptions::ReceiversAt::kSurfaces;
  axes.push_back(
      AxisOf("pipeline.object_light.route", Judge::kPicture, {"gather", "probe", "volume", "map"}));
  axes.push_back(AxisOf("pipeline.object_light.gather.rays_per_receiver",
                        Judge::kPicture,
                        {"16", "64", "256", "1024"}));
  AddProbeAxes(sweep_case, axes);
  // Hard: by shadow volumes.
  axes.push_back(
      WithValue(AxisOf("pipeline.soft_sun.disc_samples", Judge::kPicture, {"4", "8", "32", "128"}),
                {"hard", {}, Effect::kPenumbra},
                false));
  axes.push_back(WithDefault(AxisOf("influence_at", Judge::kPicture, {"pixels", "faces"}),
                             sweep_case.influence_at == InfluenceAt::kFaces ? "faces" : "pixels"));
  axes.push_back(AxisOf(
      "pipeline.effects.threshold_code_values", Judge::kPicture, {"0", "0.25", "1", "4", "16"}));
  axes.push_back(
      WithDefault(AxisOf("pipeline.view.sun_block_px", Judge::kPicture, {"1", "2", "4", "8"}),
                  on_surfaces ? "4" : "1"));
  // On surfaces there are no blocks of receivers.
  if (!on_surfaces) {
    axes.push_back(
        AxisOf("pipeline.view.receiver_block_px", Judge::kPicture, {"2", "4", "8", "16"}));
  }
  axes.push_back(AxisOf("compositor.object_samples_per_side", Judge::kPicture, {"2", "4", "8"}));
}

void AddDaylightAxes(std::vector<SweepAxis>& axes) {
  const std::string sampled = "daylight=samples";
  axes.push_back(
      WithValue(AxisOf(kSamplesOfSky, Judge::kPicture, {"16", "64", "256", "1024"}, {sampled}),
                {"gather", {"daylight=gather"}, std::nullopt},
                true));
  axes.push_back(AxisOf("pipeline.object_light.direct_daylight.shadows.map_size_px",
                        Judge::kPicture,
                        {"16", "32", "64", "128", "0"},
                        {sampled}));
  axes.push_back(AxisOf("pipeline.object_light.direct_daylight.sampling.restriction",
                        Judge::kPicture,
                        {"windows", "rejection", "whole-sky"},
                        {sampled, kSamplesOfSky + "=64"}));
}

}  // namespace

void SweepValue::ApplyTo(SessionOptions& options) const {
  for (const std::string& assignment : assignments) ApplySetting(assignment, options);
  if (without) options.pipeline.effects[*without] = EffectSwitch::kOff;
}

std::string SweepAxis::Words() const {
  const std::string& meaning = SettingOf(setting).meaning;
  if (depends_on.empty()) return meaning;
  return fmt::format("{}; with {}", meaning, fmt::join(depends_on, ", "));
}

std::vector<SweepAxis> SweepAxesFor(const SweepCase& sweep_case) {
  std::vector<SweepAxis> axes;
  if (sweep_case.light_is_fitted) AddLightAxes(axes);
  if (sweep_case.light_is_fitted || sweep_case.has_pictures) AddPreparedAxes(sweep_case, axes);
  if (!sweep_case.has_pictures) return axes;
  if (!sweep_case.light_is_fitted) {
    axes.push_back(
        AxisOf("sky_regions", Judge::kPicture, {"1x1", "2x8", "4x16", "8x32", "picture"}));
  }
  AddPictureAxes(sweep_case, axes);
  if (sweep_case.is_indoors) AddDaylightAxes(axes);
  return axes;
}

}  // namespace pleinair
