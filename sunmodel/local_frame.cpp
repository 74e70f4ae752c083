#include "sunmodel/local_frame.h"

#include <GeographicLib/LocalCartesian.hpp>

#include "sunmodel/angles.h"

namespace pleinair {
namespace {

GeographicLib::LocalCartesian FrameAt(const Site& origin) {
  origin.Validate();
  return {DegFromRad(origin.latitude_rad), DegFromRad(origin.longitude_rad), origin.height_m};
}

}  // namespace

glm::dvec3 EnuOf(const Site& place, const Site& origin) {
  place.Validate();
  glm::dvec3 enu;
  FrameAt(origin).Forward(DegFromRad(place.latitude_rad),
                          DegFromRad(place.longitude_rad),
                          place.height_m,
                          enu.x,
                          enu.y,
                          enu.z);
  return enu;
}

Site PlaceAt(const glm::dvec3& enu_m, const Site& origin) {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  Site place;
  FrameAt(origin).Reverse(enu_m.x, enu_m.y, enu_m.z, latitude_deg, longitude_deg, place.height_m);
  place.latitude_rad = RadFromDeg(latitude_deg);
  place.longitude_rad = RadFromDeg(longitude_deg);
  return place;
}

}  // namespace pleinair
