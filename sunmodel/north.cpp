#include "sunmodel/north.h"

#include <chrono>
#include <cmath>
#include <exception>
#include <stdexcept>

#include <GeographicLib/MagneticModel.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include "sunmodel/angles.h"

namespace pleinair {
namespace {

double FractionalYear(UtcTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year year = std::chrono::year_month_day(day).year();
  const UtcTime start = std::chrono::sys_days(year / 1 / 1);
  const UtcTime end = std::chrono::sys_days((year + std::chrono::years(1)) / 1 / 1);
  const auto count = [](std::chrono::nanoseconds span) {
    return static_cast<double>(span.count());
  };
  return int(year) + count(time - start) / count(end - start);
}

}  // namespace

double GridNorthAzimuthRad(const Site& site) {
  site.Validate();
  int zone = 0;
  bool northern = true;
  double easting_m = 0.0;
  double northing_m = 0.0;
  double convergence_deg = 0.0;
  double scale = 1.0;
  GeographicLib::UTMUPS::Forward(DegFromRad(site.latitude_rad),
                                 DegFromRad(site.longitude_rad),
                                 zone,
                                 northern,
                                 easting_m,
                                 northing_m,
                                 convergence_deg,
                                 scale);
  return RadFromDeg(convergence_deg);
}

double MagneticNorthAzimuthRad(const Site& site, UtcTime time, const MagneticModelFile& model) {
  site.Validate();
  const std::string folder = model.folder.empty()
                                 ? GeographicLib::MagneticModel::DefaultMagneticPath()
                                 : model.folder.string();
  const auto refuse = [&](const std::string& reason) {
    throw std::runtime_error("magnetic model " + model.name + " in " + folder + ": " + reason);
  };
  try {
    const GeographicLib::MagneticModel field(model.name, folder);
    const double year = FractionalYear(time);
    if (!(year >= field.MinTime() && year <= field.MaxTime())) {
      refuse("year " + std::to_string(year) + ", expected " + std::to_string(field.MinTime()) +
             " to " + std::to_string(field.MaxTime()));
    }
    if (!(site.height_m >= field.MinHeight() && site.height_m <= field.MaxHeight())) {
      refuse("height " + std::to_string(site.height_m) + " m, expected " +
             std::to_string(field.MinHeight()) + " to " + std::to_string(field.MaxHeight()) + " m");
    }
    double east_nt = 0.0;
    double north_nt = 0.0;
    double up_nt = 0.0;
    field(year,
          DegFromRad(site.latitude_rad),
          DegFromRad(site.longitude_rad),
          site.height_m,
          east_nt,
          north_nt,
          up_nt);
    return std::atan2(east_nt, north_nt);
  } catch (const GeographicLib::GeographicErr& error) {
    refuse(std::string("not there or damaged (geographiclib-get-magnetic fetches models): ") +
           error.what());
  }
  return 0.0;  // Not reached: refuse throws.
}

glm::dvec3 TurnedClockwise(const glm::dvec3& direction_enu, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {c * direction_enu.x + s * direction_enu.y,
          -s * direction_enu.x + c * direction_enu.y,
          direction_enu.z};
}

}  // namespace pleinair
