#include "session/check/map_check.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "scene/lat_long.h"
#include "session/check/segment_fit.h"

namespace pleinair {
namespace {

constexpr int kMapWidth = 144;  // 2.5 deg a pixel: wrong layouts are further off.
constexpr int kMapHeight = 72;

constexpr double kLeastExplainedMap = 0.35;
// Good maps of the recordings gain up to 0.02 by some turn or mirror; wrong ones 0.14 and more.
constexpr double kLeastGain = 0.08;
// Among layouts that explain nearly as much as the best, the first without a turn is chosen:
// surroundings are often nearly symmetrical.
constexpr double kAsGood = 0.03;

}  // namespace

bool MapLayoutFit::ContradictsTheMap() const {
  constexpr double kWorthAWarningRad = 0.18;  // 10 deg.
  if (best == MapLayout::kAsStated && std::abs(turn_rad) < kWorthAWarningRad) return false;
  return explained >= kLeastExplainedMap && explained - explained_as_stated >= kLeastGain;
}

MapLayoutFit FitMapLayout(const RgbImage& map,
                          const glm::dvec3& position_m,
                          const Mesh& mesh,
                          const RayCaster& caster) {
  const LatLongSize size{kMapWidth, kMapHeight};
  const auto direction = [&](int x, int y) {
    return DirectionFromLatLong({x + 0.5, y + 0.5}, size);
  };
  const Segments segments =
      SegmentsOf(mesh, caster, {position_m, kMapWidth, kMapHeight, direction});
  RgbImage small(kMapWidth, kMapHeight);
  for (int y = 0; y < kMapHeight; ++y) {
    for (int x = 0; x < kMapWidth; ++x) small.At(x, y) = SampleLatLong(map, direction(x, y));
  }
  const RgbImage picture = LogRadiance(small);
  const auto weight = [&](int y) { return LatLongPixelSolidAngleSr(y, size); };

  MapLayoutFit fit;
  std::vector<MapLayoutFit> unturned;
  for (const MapLayout layout : {MapLayout::kAsStated,
                                 MapLayout::kUpsideDown,
                                 MapLayout::kHalfTurned,
                                 MapLayout::kMirrored}) {
    const bool rows = layout == MapLayout::kUpsideDown || layout == MapLayout::kHalfTurned;
    const bool columns = layout == MapLayout::kMirrored || layout == MapLayout::kHalfTurned;
    for (int turn = 0; turn < kMapWidth; ++turn) {
      const auto source = [&](int x, int y) {
        const int turned = (x + kMapWidth - turn) % kMapWidth;
        return &picture.At(columns ? kMapWidth - 1 - turned : turned,
                           rows ? kMapHeight - 1 - y : y);
      };
      const int centred = turn < kMapWidth / 2 ? turn : turn - kMapWidth;
      const MapLayoutFit tried{layout,
                               2.0 * std::numbers::pi * centred / kMapWidth,
                               ExplainedShare(segments, source, weight)};
      if (turn == 0) unturned.push_back(tried);
      if (tried.explained > fit.explained) fit = tried;
    }
  }
  for (const MapLayoutFit& tried : unturned) {
    if (tried.explained < fit.explained - kAsGood) continue;
    fit = tried;
    break;
  }
  fit.explained_as_stated = unturned.front().explained;
  return fit;
}

}  // namespace pleinair
