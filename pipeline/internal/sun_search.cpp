#include "pipeline/internal/sun_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

constexpr double kNearAzimuthRad = RadFromDeg(3.0);
constexpr double kNearElevationRad = RadFromDeg(4.0);
constexpr double kFirstStepRad = RadFromDeg(6.0);
constexpr double kLastStepRad = RadFromDeg(1.5);
constexpr double kLowestRad = RadFromDeg(4.0);
constexpr double kHighestRad = RadFromDeg(86.0);
// So many of the pixels are used for each of some 700 suns.
constexpr std::size_t kSearchPixels = 2000;

struct Place {
  double azimuth_rad = 0.0;
  double elevation_rad = 0.0;

  glm::dvec3 DirectionEnu() const {
    return {std::sin(azimuth_rad) * std::cos(elevation_rad),
            std::cos(azimuth_rad) * std::cos(elevation_rad),
            std::sin(elevation_rad)};
  }
};

ShadowPicture EvenChoice(const ShadowPicture& picture) {
  const std::size_t every = std::max<std::size_t>(1, picture.Size() / kSearchPixels);
  ShadowPicture few;
  for (std::size_t i = 0; i < picture.Size(); i += every) {
    few.surface.push_back(picture.surface[i]);
    few.log_radiance.push_back(picture.log_radiance[i]);
    few.log_blue_over_red.push_back(picture.log_blue_over_red[i]);
    few.plane.push_back(picture.plane[i]);
    few.tile.push_back(picture.tile[i]);
  }
  return few;
}

class Search {
 public:
  Search(const ShadowPicture& picture, const RayCaster& caster, const std::stop_token& stop)
      : picture_(EvenChoice(picture)), caster_(caster), stop_(stop) {}

  struct Best {
    Place place;
    double misfit = 0.0;
  };
  Best BestOf(std::span<const Place> places) {
    CastFor(places);
    const std::vector<double> misfit = MisfitByCandidate(picture_);
    const auto least = std::min_element(misfit.begin(), misfit.end());
    return {places[static_cast<std::size_t>(least - misfit.begin())], *least};
  }

  double AgreementUnder(const Place& place) {
    CastFor(std::span(&place, 1));
    return AgreementOfStates(picture_, 0);
  }

 private:
  void CastFor(std::span<const Place> places) {
    std::vector<glm::dvec3> suns;
    for (const Place& place : places) suns.push_back(place.DirectionEnu());
    picture_.candidates = suns.size();
    picture_.shares = SharesOfSuns(picture_.surface, caster_, suns, stop_);
  }

  ShadowPicture picture_;
  const RayCaster& caster_;
  const std::stop_token& stop_;
};

std::vector<Place> Around(const Place& middle, double step_rad, int reach) {
  std::vector<Place> places;
  const double widen = 1.0 / std::max(std::cos(middle.elevation_rad), 0.2);
  for (int row = -reach; row <= reach; ++row) {
    for (int column = -reach; column <= reach; ++column) {
      const double elevation_rad = middle.elevation_rad + row * step_rad;
      if (elevation_rad < kLowestRad || elevation_rad > kHighestRad) continue;
      places.push_back({middle.azimuth_rad + column * step_rad * widen, elevation_rad});
    }
  }
  return places;
}

}  // namespace

SunSearch SearchSun(const ShadowPicture& picture,
                    const RayCaster& caster,
                    const glm::dvec3& stated_sun_enu,
                    const std::stop_token& stop) {
  SunSearch result;
  result.direction_enu = stated_sun_enu;
  if (picture.Size() == 0) return result;
  Search search(picture, caster, stop);
  const Place stated{std::atan2(stated_sun_enu.x, stated_sun_enu.y),
                     std::atan2(stated_sun_enu.z, std::hypot(stated_sun_enu.x, stated_sun_enu.y))};

  std::vector<Place> places;
  for (double elevation_rad = kLowestRad + 0.5 * kFirstStepRad; elevation_rad <= kHighestRad;
       elevation_rad += kFirstStepRad) {
    const int count = std::max(
        8, static_cast<int>(2.0 * std::numbers::pi * std::cos(elevation_rad) / kFirstStepRad));
    for (int k = 0; k < count; ++k) {
      places.push_back({2.0 * std::numbers::pi * k / count, elevation_rad});
    }
  }
  places.push_back(stated);
  Search::Best best = search.BestOf(places);
  for (double step_rad = 0.5 * kFirstStepRad; step_rad >= kLastStepRad; step_rad *= 0.5) {
    best = search.BestOf(Around(best.place, step_rad, 2));
  }

  std::vector<Place> near;
  for (const double azimuth_rad : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    for (const double elevation_rad : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      near.push_back({stated.azimuth_rad + azimuth_rad * kNearAzimuthRad,
                      stated.elevation_rad + elevation_rad * kNearElevationRad});
    }
  }
  const Search::Best best_near = search.BestOf(near);
  // The last one has no sun: one level for each plane.
  result.agreement = search.AgreementUnder(best.place);
  // Below the horizon, no pixel has sun: one level for each plane.
  const double without_sun =
      search.BestOf(std::vector<Place>{{0.0, -0.5 * std::numbers::pi}}).misfit;
  result.direction_enu = best.place.DirectionEnu();
  if (without_sun > 0.0) {
    result.explained = 1.0 - best.misfit / without_sun;
    result.explained_near_stated = 1.0 - best_near.misfit / without_sun;
  }
  return result;
}

}  // namespace pleinair
