#include "apps/sun_command.h"

#include <array>
#include <cstdarg>
#include <cstdio>
#include <optional>

#include <nlohmann/json.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/clear_sky.h"
#include "sunmodel/refraction.h"
#include "sunmodel/site.h"
#include "sunmodel/sun_position.h"
#include "sunmodel/sunrise_sunset.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSpanWarning =
    "the year is outside 1900 to 2100, where the ephemeris promises its accuracy";

struct SunAnswer {
  Site site;
  UtcTime time;
  Atmosphere air;
  SunPosition airless;
  SunPosition apparent;
  std::optional<double> air_mass;  // None below the horizon.
  ClearSkyIrradiance clear_sky;
  SolarDay day;
};

SunAnswer Answer(const SunCommandOptions& options) {
  SunAnswer answer;
  answer.site = ParseSite(options.site);
  answer.time = ParseUtcTime(options.time);
  answer.air = StandardAtmosphere(answer.site.height_m);
  if (options.pressure_hpa) answer.air.pressure_hpa = *options.pressure_hpa;
  if (options.temperature_c) answer.air.temperature_c = *options.temperature_c;
  answer.air.Validate();

  const EarthRotation rotation{options.ut1_minus_utc_s, options.tt_minus_ut1_s};
  answer.airless = ComputeSunPosition(answer.site, answer.time, rotation);
  answer.apparent = answer.airless;
  answer.apparent.direction_enu = ApparentDirection(answer.airless.direction_enu, answer.air);
  const double elevation_rad = answer.apparent.ElevationRad();
  if (elevation_rad >= 0.0) answer.air_mass = RelativeAirMass(elevation_rad);
  ClearSkyConditions conditions;
  conditions.sun_distance_au = answer.airless.distance_au;
  answer.clear_sky = ComputeClearSky(answer.site, elevation_rad, conditions);
  answer.day = FindSolarDay(answer.site, answer.time, answer.air, rotation);
  return answer;
}

// Whole seconds: refraction at the horizon is not known to more.
std::string ToTheSecond(UtcTime time) {
  return FormatUtcTime(std::chrono::round<std::chrono::seconds>(time));
}

const char* DayText(const SolarDay& day) {
  if (day.sunrise && day.sunset) return "rises and sets";
  if (day.sunrise) return "rises only";
  if (day.sunset) return "sets only";
  return day.sun_up_at_noon ? "up all day" : "down all day";
}

Json JsonFrom(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }

Json JsonFrom(const std::optional<UtcTime>& time) {
  return time ? Json(ToTheSecond(*time)) : Json(nullptr);
}

std::string JsonText(const SunAnswer& answer) {
  Json json;
  json["time_utc"] = FormatUtcTime(answer.time);
  json["latitude_deg"] = DegFromRad(answer.site.latitude_rad);
  json["longitude_deg"] = DegFromRad(answer.site.longitude_rad);
  json["height_m"] = answer.site.height_m;
  json["azimuth_deg"] = DegFromRad(answer.airless.AzimuthRad());
  json["elevation_deg"] = DegFromRad(answer.airless.ElevationRad());
  json["direction_enu"] = JsonFrom(answer.airless.direction_enu);
  json["apparent_elevation_deg"] = DegFromRad(answer.apparent.ElevationRad());
  json["apparent_direction_enu"] = JsonFrom(answer.apparent.direction_enu);
  json["angular_radius_deg"] = DegFromRad(answer.airless.angular_radius_rad);
  json["distance_au"] = answer.airless.distance_au;
  json["pressure_hpa"] = answer.air.pressure_hpa;
  json["temperature_c"] = answer.air.temperature_c;
  json["air_mass"] = answer.air_mass ? Json(*answer.air_mass) : Json(nullptr);
  json["clear_sky_beam_w_m2_rgb"] = JsonFrom(answer.clear_sky.beam_rgb);
  json["clear_sky_diffuse_w_m2_rgb"] = JsonFrom(answer.clear_sky.diffuse_rgb);
  json["sunrise_utc"] = JsonFrom(answer.day.sunrise);
  json["solar_noon_utc"] = ToTheSecond(answer.day.noon);
  json["sunset_utc"] = JsonFrom(answer.day.sunset);
  json["solar_day"] = DayText(answer.day);
  if (!IsInEphemerisSpan(answer.time)) json["warning"] = kSpanWarning;
  return json.dump(2) + "\n";
}

// A row of the table: name, value, unit, and a word on what it is.
class Table {
 public:
  [[gnu::format(printf, 4, 5)]] void Row(const char* name,
                                         const char* remark,
                                         const char* format,
                                         ...) {
    std::array<char, 128> value{};
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(value.data(), value.size(), format, arguments);
    va_end(arguments);
    std::array<char, 256> line{};
    std::snprintf(line.data(), line.size(), "%-20s %-42s %s", name, value.data(), remark);
    text_ += line.data();
    text_.erase(text_.find_last_not_of(' ') + 1);
    text_ += '\n';
  }

  const std::string& Text() const { return text_; }

 private:
  std::string text_;
};

void RowOfRising(Table& table,
                 const char* name,
                 const std::optional<UtcTime>& time,
                 const SolarDay& day) {
  const std::string value = time ? ToTheSecond(*time) : std::string("none: ") + DayText(day);
  table.Row(name, time ? "upper limb at the horizon" : "", "%s", value.c_str());
}

std::string TableText(const SunAnswer& answer) {
  const auto vector = [](const glm::dvec3& v) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.6f %.6f %.6f", v.x, v.y, v.z);
    return std::string(text.data());
  };
  const auto rgb = [](const glm::dvec3& v) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.1f %.1f %.1f W/m2", v.x, v.y, v.z);
    return std::string(text.data());
  };
  const auto degrees = [](double rad) { return DegFromRad(rad); };

  Table table;
  table.Row("site",
            "north, east, over the ellipsoid",
            "%.6f deg, %.6f deg, %.1f m",
            degrees(answer.site.latitude_rad),
            degrees(answer.site.longitude_rad),
            answer.site.height_m);
  table.Row("time", "UTC", "%s", FormatUtcTime(answer.time).c_str());
  table.Row(
      "azimuth", "clockwise from true north", "%.4f deg", degrees(answer.airless.AzimuthRad()));
  table.Row("elevation", "airless", "%.4f deg", degrees(answer.airless.ElevationRad()));
  table.Row("apparent elevation", "refracted", "%.4f deg", degrees(answer.apparent.ElevationRad()));
  table.Row(
      "direction", "east, north, up; airless", "%s", vector(answer.airless.direction_enu).c_str());
  table.Row("apparent direction",
            "east, north, up; refracted",
            "%s",
            vector(answer.apparent.direction_enu).c_str());
  table.Row(
      "angular radius", "of the disc", "%.4f deg", degrees(answer.airless.angular_radius_rad));
  table.Row("distance", "", "%.6f au", answer.airless.distance_au);
  table.Row("air",
            "standard atmosphere where not given",
            "%.2f hPa, %.2f C",
            answer.air.pressure_hpa,
            answer.air.temperature_c);
  if (answer.air_mass) table.Row("air mass", "1 at the zenith", "%.4f", *answer.air_mass);
  table.Row("clear-sky beam",
            "red, green, blue; normal to the beam",
            "%s",
            rgb(answer.clear_sky.beam_rgb).c_str());
  table.Row("clear-sky diffuse",
            "red, green, blue; on the horizontal",
            "%s",
            rgb(answer.clear_sky.diffuse_rgb).c_str());
  RowOfRising(table, "sunrise", answer.day.sunrise, answer.day);
  table.Row("solar noon", "centre on the meridian", "%s", ToTheSecond(answer.day.noon).c_str());
  RowOfRising(table, "sunset", answer.day.sunset, answer.day);
  return table.Text();
}

}  // namespace

std::string RunSunCommand(const SunCommandOptions& options) {
  const SunAnswer answer = Answer(options);
  return options.json ? JsonText(answer) : TableText(answer);
}

std::optional<std::string> SunCommandWarning(const SunCommandOptions& options) {
  const UtcTime time = ParseUtcTime(options.time);
  if (IsInEphemerisSpan(time)) return std::nullopt;
  return "time '" + options.time + "': " + kSpanWarning;
}

}  // namespace pleinair
