#include "sunmodel/site.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "scene/trimmed.h"
#include "sunmodel/angles.h"
#include "sunmodel/internal/number_text.h"

namespace pleinair {
namespace {

// From below the deepest sea floor to above any low orbit: a height in other units is caught.
constexpr double kLowestM = -11.0e3;
constexpr double kHighestM = 1.0e6;

[[noreturn]] void Refuse(std::string_view text, const std::string& what) {
  throw std::invalid_argument("site '" + std::string(text) + "': " + what);
}

// Blanks around it are ignored: maps copy "57.0488, 9.9217".
double ParseField(std::string_view text, std::string_view field, const char* name) {
  field = Trimmed(field);
  double value = 0.0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    Refuse(text,
           std::string(name) + " is '" + std::string(field) +
               "', expected a number (the form is LAT,LON or LAT,LON,H)");
  }
  return value;
}

}  // namespace

void Site::Validate() const {
  if (!(std::abs(latitude_rad) <= std::numbers::pi / 2.0)) {
    throw std::invalid_argument("site: latitude_rad is " + NumberText(latitude_rad) +
                                ", expected -pi/2 to pi/2");
  }
  if (!std::isfinite(longitude_rad)) {
    throw std::invalid_argument("site: longitude_rad is " + NumberText(longitude_rad) +
                                ", expected a finite angle");
  }
  if (!std::isfinite(model_north_azimuth_rad)) {
    throw std::invalid_argument("site: model_north_azimuth_rad is " +
                                NumberText(model_north_azimuth_rad) + ", expected a finite angle");
  }
  if (!(height_m >= kLowestM && height_m <= kHighestM)) {
    throw std::invalid_argument("site: height_m is " + NumberText(height_m) + ", expected " +
                                NumberText(kLowestM) + " to " + NumberText(kHighestM));
  }
}

Site ParseSite(std::string_view text) {
  const std::size_t first = text.find(',');
  if (first == std::string_view::npos) Refuse(text, "expected LAT,LON or LAT,LON,H");
  const std::size_t second = text.find(',', first + 1);
  const double latitude_deg = ParseField(text, text.substr(0, first), "latitude");
  const double longitude_deg =
      ParseField(text, text.substr(first + 1, second - first - 1), "longitude");
  const double height_m =
      second == std::string_view::npos ? 0.0 : ParseField(text, text.substr(second + 1), "height");
  if (!(std::abs(latitude_deg) <= 90.0)) {
    Refuse(text, "latitude is " + NumberText(latitude_deg) + " deg, expected -90 to 90");
  }
  if (!(std::abs(longitude_deg) <= 360.0)) {
    Refuse(text, "longitude is " + NumberText(longitude_deg) + " deg, expected -360 to 360");
  }
  if (!(height_m >= kLowestM && height_m <= kHighestM)) {
    Refuse(text,
           "height is " + NumberText(height_m) + " m, expected " + NumberText(kLowestM) + " to " +
               NumberText(kHighestM));
  }
  return {RadFromDeg(latitude_deg), RadFromDeg(longitude_deg), height_m};
}

}  // namespace pleinair
