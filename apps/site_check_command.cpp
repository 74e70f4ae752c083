#include "apps/site_check_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/progress.h"
#include "apps/site_day_picture.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
#include "session/check/site_check.h"
#include "session/survey_map_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

bool IsSite(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::exists(folder / "site.json", error);
}

UtcTime NoonOf(const std::string& day) {
  try {
    return ParseUtcTime(day + "T12:00:00Z");
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("--day " + day + ": expected YYYY-MM-DD");
  }
}

double ElevationDeg(const glm::dvec3& direction_enu) {
  return DegFromRad(std::asin(std::clamp(direction_enu.z, -1.0, 1.0)));
}

double AzimuthDeg(const glm::dvec3& direction_enu) {
  const double azimuth = DegFromRad(std::atan2(direction_enu.x, direction_enu.y));
  return azimuth < 0.0 ? azimuth + 360.0 : azimuth;
}

std::string DayText(UtcTime noon) { return FormatUtcTime(noon).substr(0, 10); }

// Why sun and sky cannot be separated, as far as the view shows.
std::string Verdict(const SiteHour& hour) {
  if (!(hour.light.sun.direction_enu.z > 0.0)) return "not known: the sun is at the horizon";
  if (!hour.light.estimate) return "measured by the fish-eye camera";
  constexpr double kLowSunDeg = 8.0;
  const bool is_low = ElevationDeg(hour.light.sun.direction_enu) < kLowSunDeg;
  if (!*hour.light.estimate && is_low) return "not known: low sun";
  if (!*hour.light.estimate) return "no estimate: " + hour.light.estimate->error().reason;
  // Share of the picture; 500 samples need some per cent.
  constexpr double kFewPixels = 0.01;
  if (SunWillBeKnown(hour)) {
    return hour.light.lit_share < kFewPixels ? "known by reflected sunlight alone" : "known";
  }
  if (hour.light.lit_share < kFewPixels && hour.light.shaded_share < kFewPixels) {
    return "not known: no diffuse surface in view";
  }
  if (hour.light.lit_share < kFewPixels) return "not known: no sunlit surface in view";
  if (hour.light.shaded_share < kFewPixels) return "not known: no shaded surface in view";
  if (is_low) return "not known: low sun";
  return "not known: lit and shaded surfaces are too few or too uncertain";
}

std::string PercentText(const std::optional<double>& share) {
  if (!share) return "-";
  return *share > 9.99 ? ">999" : fmt::format("{:.1f}", 100.0 * *share);
}

std::string DayTable(const SiteDay& day) {
  std::string text = fmt::format("clear sky of {}", DayText(day.sun.noon));
  const auto hour_text = [](UtcTime time) { return FormatUtcTime(time).substr(11, 5) + "Z"; };
  if (day.sun.sunrise) text += ", sunrise " + hour_text(*day.sun.sunrise);
  text += ", solar noon " + hour_text(day.sun.noon);
  if (day.sun.sunset) text += ", sunset " + hour_text(*day.sun.sunset);
  text += "\n";
  if (day.hours.empty()) return text + "the sun does not rise on this day\n";
  text += fmt::format("{:>6} {:>6} {:>5} {:>6} {:>8} {:>9} {:>10} {:>10}  {}\n",
                      "UTC",
                      "sun az",
                      "el",
                      "lit %",
                      "shaded %",
                      "object %",
                      "s sun %",
                      "s sky %",
                      "sun and sky are");
  for (const SiteHour& hour : day.hours) {
    const glm::dvec3& sun = hour.light.sun.direction_enu;
    text += fmt::format("{:>6} {:>6.1f} {:>5.1f} {:>6.1f} {:>8.1f} {:>9} {:>10} {:>10}  {}\n",
                        hour_text(hour.light.time),
                        AzimuthDeg(sun),
                        ElevationDeg(sun),
                        100.0 * hour.light.lit_share,
                        100.0 * hour.light.shaded_share,
                        PercentText(hour.sun_on_objects),
                        PercentText(hour.light.sun_relative_stddev),
                        PercentText(hour.light.sky_relative_stddev),
                        Verdict(hour));
  }
  return text;
}

std::string TextOf(const SiteCheckReport& report) {
  std::string text = report.name + "\n";
  for (const SiteWarning& warning : report.warnings) {
    text += fmt::format("\nwarning: {}\n  where:  {}\n  known:  {}\n  do:     {}\n",
                        warning.what,
                        warning.where,
                        warning.evidence,
                        warning.remedy);
  }
  if (report.warnings.empty()) text += "nothing is found to be wrong\n";
  text += "\n";
  text += report.day ? DayTable(*report.day) : report.why_no_day + "\n";
  return text;
}

Json JsonOf(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::string JsonText(const SiteCheckReport& report) {
  Json json = {{"name", report.name}, {"warnings", Json::array()}};
  for (const SiteWarning& warning : report.warnings) {
    json["warnings"].push_back({{"what", warning.what},
                                {"where", warning.where},
                                {"evidence", warning.evidence},
                                {"remedy", warning.remedy}});
  }
  if (!report.day) {
    json["hours"] = nullptr;
    json["why_no_hours"] = report.why_no_day;
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  }
  const auto time_or_null = [](const std::optional<UtcTime>& time) {
    return time ? Json(FormatUtcTime(std::chrono::round<std::chrono::seconds>(*time)))
                : Json(nullptr);
  };
  json["day"] = DayText(report.day->sun.noon);
  json["sunrise_utc"] = time_or_null(report.day->sun.sunrise);
  json["solar_noon_utc"] = time_or_null(report.day->sun.noon);
  json["sunset_utc"] = time_or_null(report.day->sun.sunset);
  json["hours"] = Json::array();
  for (const SiteHour& hour : report.day->hours) {
    const LightForecast& light = hour.light;
    json["hours"].push_back({{"time_utc", FormatUtcTime(light.time)},
                             {"sun_azimuth_deg", AzimuthDeg(light.sun.direction_enu)},
                             {"sun_elevation_deg", ElevationDeg(light.sun.direction_enu)},
                             {"lit_share", light.lit_share},
                             {"shaded_share", light.shaded_share},
                             {"sun_on_objects_share", JsonOf(hour.sun_on_objects)},
                             {"sun_relative_stddev", JsonOf(light.sun_relative_stddev)},
                             {"sky_relative_stddev", JsonOf(light.sky_relative_stddev)},
                             {"sun_observable", SunWillBeKnown(hour)},
                             {"verdict", Verdict(hour)}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Whether preparation would be for another place than the intended one.
bool IsMeaningless(const SiteWarnings& warnings) {
  return std::any_of(warnings.begin(), warnings.end(), [](const SiteWarning& warning) {
    return warning.spoils_forecast;
  });
}

// Warns where no hour is usable although the sun rises high enough.
void WarnOfUnknownSun(const SiteDay& day, const std::string& name, SiteWarnings& warnings) {
  constexpr double kHighSunDeg = 10.0;
  int high = 0;
  for (const SiteHour& hour : day.hours) {
    if (!hour.light.estimate || SunWillBeKnown(hour)) return;
    if (ElevationDeg(hour.light.sun.direction_enu) >= kHighSunDeg) ++high;
  }
  if (high == 0) return;
  warnings.push_back(
      {"at no hour of this day can sun and sky be separated",
       name,
       fmt::format("in {} clear hours with the sun at {:.0f} deg or more the expected deviation of "
                   "the sun is 15 % of the beam or more",
                   high,
                   kHighSunDeg),
       "turn the camera to where both lit and shaded walls or paving are in view, or name more "
       "diffuse_regions; or check another --day"});
}

}  // namespace

SiteCheckReport CheckSiteAndDay(const SiteCheckOptions& options) {
  SessionOptions session = options.session;
  const UtcTime today = std::chrono::system_clock::now();
  const bool is_site = IsSite(session.sequence);
  const UtcTime named_day = options.day.empty() ? today : NoonOf(options.day);
  Sequence sequence =
      is_site ? ReadSite(session.sequence, named_day) : ReadSequence(session.sequence);
  SiteCheckReport report;
  report.name = sequence.name;
  FindSunInMap(sequence);
  report.warnings = CheckSite(sequence, session.frames);
  if (!sequence.site) {
    report.why_no_day = "no hours: " + sequence.file.string() +
                        " has no `site` (latitude_deg, longitude_deg, height_m)";
    return report;
  }
  if (IsMeaningless(report.warnings)) {
    report.why_no_day = "no hours: first correct what the warnings name";
    return report;
  }
  const UtcTime day = options.day.empty() && !is_site ? sequence.frames.front().time : named_day;
  const auto loaded = is_site ? LoadSite(session, day, ProgressOnStandardError())
                              : LoadSequence(session, ProgressOnStandardError());
  report.day = ForecastDay(*loaded, session, day, std::chrono::minutes(options.step_min));
  WarnOfUnknownSun(*report.day, report.name, report.warnings);
  return report;
}

std::string RunSiteCheck(const SiteCheckOptions& options, bool* is_good) {
  const SiteCheckReport report = CheckSiteAndDay(options);
  *is_good = report.warnings.empty();
  std::string text = options.json ? JsonText(report) : TextOf(report);
  if (!options.out.empty() && report.day && !report.day->hours.empty()) {
    MakeFolder(options.out);
    const std::filesystem::path file = options.out / "day.png";
    WritePng(file, DrawSiteDay(report.name + ", " + DayText(report.day->sun.noon), *report.day));
    if (!options.json) text += "\npicture: " + file.string() + "\n";
  }
  return text;
}

}  // namespace pleinair
