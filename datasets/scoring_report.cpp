// A score as JSON and as a table.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
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
          {"sun_to_sky_error", Number(light->sun_to_sky_error)},
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
          {"similarity", Number(composite->similarity)},
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
          {"sun_to_sky_error", FromDistribution(summary.sun_to_sky_error)},
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

std::string Fixed(double value, int decimals) {
  char text[400];  // The longest double has 309 digits before the point.
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

// A column's entry, or a dash.
std::string Cell(const std::optional<double>& value, double unit, int decimals) {
  return value && std::isfinite(*value) ? Fixed(unit * *value, decimals) : "-";
}
std::string Percent(const std::optional<double>& share) { return Cell(share, 100.0, 2); }
std::string Decibel(const std::optional<double>& psnr) { return Cell(psnr, 1.0, 2); }
std::string Degrees(const std::optional<double>& rad) { return Cell(rad, DegFromRad(1.0), 3); }

struct Column {
  std::string text;
  int width = 0;  // Right-aligned; left-aligned where negative.
};

std::string Row(std::initializer_list<Column> columns) {
  std::string row;
  for (const Column& column : columns) {
    const auto width = static_cast<std::size_t>(std::abs(column.width));
    const std::string padding(width - std::min(width, column.text.size()), ' ');
    row += column.width < 0 ? column.text + padding : padding + column.text;
  }
  return row + "\n";
}

std::string FrameRow(const FrameScore& frame) {
  const LightScore raw = frame.raw.value_or(LightScore{});
  const LightScore light = frame.light.value_or(LightScore{});
  const CompositeScore composite = frame.composite.value_or(CompositeScore{});
  const char* posed = !frame.sunlit ? "-" : frame.IsWellPosed() ? "yes" : "no";
  return Row({{std::to_string(frame.frame), 5},
              {frame.sunlit ? Percent(frame.sunlit->lit) : "-", 8},
              {posed, 6},
              {"|", 2},
              {Percent(raw.sun_error), 7},
              {Percent(raw.sky_error), 7},
              {Degrees(raw.sun_colour_angle_rad), 7},
              {Degrees(raw.sky_colour_angle_rad), 7},
              {"|", 2},
              {Percent(light.sun_error), 7},
              {Percent(light.sky_error), 7},
              {"|", 2},
              {Degrees(light.sun_direction_error_rad), 8},
              {"|", 2},
              {Decibel(composite.object_psnr_db), 7},
              {Decibel(composite.object_psnr_without_specular_db), 7},
              {Decibel(composite.effect_psnr_db), 7},
              {Cell(composite.similarity, 1.0, 4), 8},
              {Percent(composite.identical_outside_mask), 9},
              {Percent(composite.changed_of_unchanged), 8}});
}

std::string DistributionText(const std::optional<Distribution>& distribution) {
  if (!distribution) return "-";
  return Percent(distribution->median) + " / " + Percent(distribution->percentile_95);
}

std::string CoverageText(const std::optional<SigmaCoverage>& coverage) {
  if (!coverage) return "-";
  return Fixed(100.0 * coverage->within_1, 0) + " / " + Fixed(100.0 * coverage->within_2, 0);
}

std::string SummaryRow(const char* name, const LightSummary& summary) {
  return Row({{name, -22},
              {std::to_string(summary.frames), 7},
              {DistributionText(summary.sun_error), 17},
              {DistributionText(summary.sky_error), 17},
              {DistributionText(summary.sun_to_sky_error), 17},
              {CoverageText(summary.sun_sigma), 13},
              {CoverageText(summary.sky_sigma), 13},
              {std::to_string(summary.says_what_it_does_not_know) + " of " +
                   std::to_string(summary.with_stddev),
               14}});
}

std::string CompositeRow(const char* name,
                         const std::optional<Distribution>& distribution,
                         double unit,
                         bool large_is_good) {
  if (!distribution) return Row({{name, -52}, {"-", 9}});
  const double worst = large_is_good ? distribution->smallest : distribution->largest;
  return Row({{name, -52},
              {Fixed(unit * distribution->median, 3), 9},
              {"   worst", 8},
              {Fixed(unit * worst, 3), 9},
              {"   (" + std::to_string(distribution->count) + " frames)", 0}});
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
      {"similarity", FromDistribution(score.composite.similarity)},
      {"identical_outside_mask", FromDistribution(score.composite.identical_outside_mask)},
      {"changed_of_unchanged", FromDistribution(score.composite.changed_of_unchanged)}};
  json["frames"] = Json::array();
  for (const FrameScore& frame : score.frames) json["frames"].push_back(FromFrame(frame));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ToTable(const Score& score) {
  std::string table = score.sequence + "\n\n";
  table +=
      "       sunlit  well | unfiltered: error, colour   | filtered      |     sun | on the  less  "
      " effect  struct.     same   wrong\n"
      "frame       % posed |  sun %  sky %  sun d  sky d |  sun %  sky % | dir deg | obj dB  mirr. "
      "    dB   simil.        %       %\n";
  for (const FrameScore& frame : score.frames) table += FrameRow(frame);

  table +=
      "\nlight                  frames     sun error, %     sky error, %    sun over sky, %   sun "
      "in "
      "1/2   sky in 1/2 in 3, and\n"
      "                                 median / 95th    median / 95th    median / 95th     sigma, "
      "%     sigma, % sigma <= 40 %\n";
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
      "  without glossy materials, dB", composite.object_psnr_without_specular_db, 1.0, true);
  table += CompositeRow(
      "PSNR where it changes uncovered pixels, dB", composite.effect_psnr_db, 1.0, true);
  table +=
      CompositeRow("structural similarity (SSIM) around both", composite.similarity, 1.0, true);
  table += CompositeRow(
      "unchanged outside its mask, % of pixels", composite.identical_outside_mask, 100.0, true);
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
    table.append(reason).append(": frame ").append(frames).append("\n");
  }
  return table;
}

}  // namespace pleinair
