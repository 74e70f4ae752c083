// A score as JSON and as a table.
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "datasets/scoring.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no infinity: an error in units of a standard deviation of 0 is null there.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json Number(const std::optional<double>& value) { return value ? Number(*value) : Json(nullptr); }

Json AngleDeg(const std::optional<double>& angle_rad) {
  return angle_rad ? Number(DegFromRad(*angle_rad)) : Json(nullptr);
}

Json Rgb(const std::optional<glm::dvec3>& rgb) {
  if (!rgb) return nullptr;
  return Json::array({Number(rgb->x), Number(rgb->y), Number(rgb->z)});
}

Json FromDistribution(const std::optional<Distribution>& distribution, double unit = 1.0) {
  if (!distribution) return nullptr;
  return {{"frames", distribution->count},
          {"smallest", Number(unit * distribution->smallest)},
          {"median", Number(unit * distribution->median)},
          {"percentile_95", Number(unit * distribution->percentile_95)},
          {"largest", Number(unit * distribution->largest)}};
}

Json FromLight(const std::optional<LightScore>& light) {
  if (!light) return nullptr;
  const std::optional<bool> says = light->SaysWhatItDoesNotKnow();
  return {{"sun_error", Number(light->sun_error)},
          {"sky_error", Number(light->sky_error)},
          {"sun_colour_angle_deg", AngleDeg(light->sun_colour_angle_rad)},
          {"sky_colour_angle_deg", AngleDeg(light->sky_colour_angle_rad)},
          {"sun_direction_error_deg", AngleDeg(light->sun_direction_error_rad)},
          {"sun_error_sigmas_rgb", Rgb(light->sun_error_sigmas)},
          {"sky_error_sigmas_rgb", Rgb(light->sky_error_sigmas)},
          {"sun_stddev_of_clear_beam", Number(light->sun_stddev_of_clear_beam)},
          {"sky_stddev_of_clear_beam", Number(light->sky_stddev_of_clear_beam)},
          {"says_what_it_does_not_know", says ? Json(*says) : Json(nullptr)}};
}

Json FromComposite(const std::optional<CompositeScore>& composite) {
  if (!composite) return nullptr;
  return {{"object_psnr_db", Number(composite->object_psnr_db)},
          {"object_psnr_without_specular_db", Number(composite->object_psnr_without_specular_db)},
          {"effect_psnr_db", Number(composite->effect_psnr_db)},
          {"identical_outside_mask", Number(composite->identical_outside_mask)},
          {"changed_of_unchanged", Number(composite->changed_of_unchanged)},
          {"object_pixels", composite->object_pixels},
          {"effect_pixels", composite->effect_pixels}};
}

Json FromFrame(const FrameScore& frame) {
  Json json = {{"frame", frame.frame}, {"time_utc", frame.time_utc}};
  if (frame.sunlit) {
    json["diffuse_pixels"] = frame.sunlit->diffuse_pixels;
    json["sunlit_share"] = frame.sunlit->lit;
    json["well_posed"] = frame.sunlit->IsWellPosed();
  }
  json["light"] = FromLight(frame.light);
  json["raw"] = FromLight(frame.raw);
  json["composite"] = FromComposite(frame.composite);
  if (frame.composite) json["made_from"] = frame.made_from_linear ? "linear" : "ldr";
  json["without"] = frame.without;
  return json;
}

Json FromCoverage(const std::optional<SigmaCoverage>& coverage) {
  if (!coverage) return nullptr;
  return {{"values", coverage->count},
          {"within_1_sigma", coverage->within_1},
          {"within_2_sigma", coverage->within_2}};
}

Json FromSummary(const LightSummary& summary) {
  const double deg = DegFromRad(1.0);
  return {{"frames", summary.frames},
          {"sun_error", FromDistribution(summary.sun_error)},
          {"sky_error", FromDistribution(summary.sky_error)},
          {"sun_colour_angle_deg", FromDistribution(summary.sun_colour_angle_rad, deg)},
          {"sky_colour_angle_deg", FromDistribution(summary.sky_colour_angle_rad, deg)},
          {"sun_direction_error_deg", FromDistribution(summary.sun_direction_error_rad, deg)},
          {"sun_sigma", FromCoverage(summary.sun_sigma)},
          {"sky_sigma", FromCoverage(summary.sky_sigma)},
          {"with_stddev", summary.with_stddev},
          {"says_what_it_does_not_know", summary.says_what_it_does_not_know}};
}

Json FromSummaries(const LightSummaries& summaries) {
  return {{"all", FromSummary(summaries.all)},
          {"well_posed", FromSummary(summaries.well_posed)},
          {"others", FromSummary(summaries.others)}};
}

// printf into a string.
__attribute__((format(printf, 1, 2))) std::string Printed(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

// A column's entry, or a dash.
std::string Cell(const std::optional<double>& value, double unit, const char* format) {
  char text[32];
  if (!value || !std::isfinite(*value)) return "-";
  std::snprintf(text, sizeof(text), format, unit * *value);
  return text;
}

std::string Percent(const std::optional<double>& share) { return Cell(share, 100.0, "%.2f"); }
std::string Decibel(const std::optional<double>& psnr) { return Cell(psnr, 1.0, "%.2f"); }
std::string Degrees(const std::optional<double>& rad) { return Cell(rad, DegFromRad(1.0), "%.3f"); }

std::string FrameRow(const FrameScore& frame) {
  const LightScore none;
  const LightScore& raw = frame.raw ? *frame.raw : none;
  const LightScore& light = frame.light ? *frame.light : none;
  const CompositeScore no_composite;
  const CompositeScore& composite = frame.composite ? *frame.composite : no_composite;
  const char* posed = !frame.sunlit ? "-" : frame.IsWellPosed() ? "yes" : "no";
  return Printed("%5d  %6s %5s | %6s %6s %6s %6s | %6s %6s | %7s | %6s %5s %6s %8s %7s\n",
                 frame.frame,
                 frame.sunlit ? Percent(frame.sunlit->lit).c_str() : "-",
                 posed,
                 Percent(raw.sun_error).c_str(),
                 Percent(raw.sky_error).c_str(),
                 Degrees(raw.sun_colour_angle_rad).c_str(),
                 Degrees(raw.sky_colour_angle_rad).c_str(),
                 Percent(light.sun_error).c_str(),
                 Percent(light.sky_error).c_str(),
                 Degrees(light.sun_direction_error_rad).c_str(),
                 Decibel(composite.object_psnr_db).c_str(),
                 Decibel(composite.object_psnr_without_specular_db).c_str(),
                 Decibel(composite.effect_psnr_db).c_str(),
                 Percent(composite.identical_outside_mask).c_str(),
                 Percent(composite.changed_of_unchanged).c_str());
}

std::string DistributionText(const std::optional<Distribution>& distribution) {
  if (!distribution) return "-";
  return Printed("%.2f / %.2f", 100.0 * distribution->median, 100.0 * distribution->percentile_95);
}

std::string CoverageText(const std::optional<SigmaCoverage>& coverage) {
  if (!coverage) return "-";
  return Printed("%.0f / %.0f", 100.0 * coverage->within_1, 100.0 * coverage->within_2);
}

std::string SummaryRow(const char* name, const LightSummary& summary) {
  return Printed("%-22s %6d  %15s  %15s  %11s  %11s  %6d of %d\n",
                 name,
                 summary.frames,
                 DistributionText(summary.sun_error).c_str(),
                 DistributionText(summary.sky_error).c_str(),
                 CoverageText(summary.sun_sigma).c_str(),
                 CoverageText(summary.sky_sigma).c_str(),
                 summary.says_what_it_does_not_know,
                 summary.with_stddev);
}

std::string CompositeRow(const char* name,
                         const std::optional<Distribution>& distribution,
                         double unit,
                         bool large_is_good) {
  if (!distribution) return Printed("%-52s -\n", name);
  return Printed("%-52s %8.3f   worst %8.3f   (%d frames)\n",
                 name,
                 unit * distribution->median,
                 unit * (large_is_good ? distribution->smallest : distribution->largest),
                 distribution->count);
}

}  // namespace

std::string ToJson(const Score& score) {
  Json json = {{"format", "pleinair-score"},
               {"version", 1},
               {"sequence", score.sequence},
               {"largest_true_sun", score.largest_true_sun},
               {"light", FromSummaries(score.light)},
               {"raw", FromSummaries(score.raw)}};
  json["composite"] = {
      {"object_psnr_db", FromDistribution(score.composite.object_psnr_db)},
      {"object_psnr_without_specular_db",
       FromDistribution(score.composite.object_psnr_without_specular_db)},
      {"effect_psnr_db", FromDistribution(score.composite.effect_psnr_db)},
      {"identical_outside_mask", FromDistribution(score.composite.identical_outside_mask)},
      {"changed_of_unchanged", FromDistribution(score.composite.changed_of_unchanged)}};
  json["frames"] = Json::array();
  for (const FrameScore& frame : score.frames) json["frames"].push_back(FromFrame(frame));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ToTable(const Score& score) {
  std::string table = score.sequence + "\n\n";
  table +=
      "       sunlit  well | unfiltered: error, colour   | filtered      |     sun | object  less "
      "effect     same   wrong\n"
      "frame       % posed |  sun %  sky %  sun d  sky d |  sun %  sky % | dir deg |     dB mirr. "
      "    dB        %       %\n";
  for (const FrameScore& frame : score.frames) table += FrameRow(frame);

  table +=
      "\nlight                  frames    sun error, %    sky error, %  sun in 1/2   sky in 1/2  "
      "all in 3 sigma,\n"
      "                                 median / 95th   median / 95th   sigma, %     sigma, %   "
      "sigma <= 40 %\n";
  table += SummaryRow("unfiltered", score.raw.all);
  table += SummaryRow("  well posed", score.raw.well_posed);
  table += SummaryRow("  others", score.raw.others);
  table += SummaryRow("filtered", score.light.all);
  table += SummaryRow("  well posed", score.light.well_posed);
  table += SummaryRow("  others", score.light.others);

  const CompositeSummary& composite = score.composite;
  table += "\ncomposite, medians\n";
  table += CompositeRow("PSNR on the object, dB", composite.object_psnr_db, 1.0, true);
  table += CompositeRow(
      "  without mirroring materials, dB", composite.object_psnr_without_specular_db, 1.0, true);
  table += CompositeRow(
      "PSNR where it changes what it does not cover, dB", composite.effect_psnr_db, 1.0, true);
  table += CompositeRow("outside its mask the camera's own, % of pixels",
                        composite.identical_outside_mask,
                        100.0,
                        true);
  table += CompositeRow("changed though unchanged in truth, % of pixels",
                        composite.changed_of_unchanged,
                        100.0,
                        false);
  std::map<std::string, std::string> frames_by_reason;
  for (const FrameScore& frame : score.frames) {
    for (const std::string& reason : frame.without) {
      std::string& frames = frames_by_reason[reason];
      frames += (frames.empty() ? "" : ", ") + std::to_string(frame.frame);
    }
  }
  if (!frames_by_reason.empty()) table += "\nnot scored\n";
  for (const auto& [reason, frames] : frames_by_reason) {
    table += reason + ": frame " + frames + "\n";
  }
  return table;
}

}  // namespace pleinair
