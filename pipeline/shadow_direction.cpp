#include "pipeline/shadow_direction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <glm/geometric.hpp>

#include "pipeline/internal/offset_posterior.h"
#include "pipeline/internal/shadow_evidence.h"
#include "pipeline/internal/shadow_picture.h"
#include "pipeline/internal/shadow_pixels.h"
#include "pipeline/internal/sun_search.h"
#include "scene/angle_between.h"
#include "scene/ray_caster.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

constexpr int kTilesPerBlock = 4;
// The levels of lit and shaded are read under the best candidate, which moves with them.
constexpr int kMostRounds = 2;
// Heights of casters are trusted as though the sun's elevation were known to +-4 deg.
constexpr int kRaisedSteps = 6;
constexpr double kRaisedStepRad = RadFromDeg(0.6667);
constexpr double kLeastRaisedElevationRad = RadFromDeg(1.0);
constexpr double kLargestRaisedElevationRad = RadFromDeg(89.0);
// Below, the sun's shadows are longer than any mesh is right; above, its azimuth hardly turns them.
constexpr double kLeastElevationRad = RadFromDeg(3.0);
constexpr double kLargestElevationRad = RadFromDeg(85.0);
// An answer has to be better than this, and rest on this many tiles.
constexpr double kLargestStddevRad = RadFromDeg(3.0);
constexpr std::size_t kLeastTiles = 4;
// Two estimates of the uncertainty that differ by more than this belong to two different answers.
constexpr double kLargestStddevRatio = 6.0;
constexpr double kClearlyOffRad = RadFromDeg(0.5);
constexpr double kClearlyOffSigmas = 3.0;
constexpr double kWorthAWarningRad = RadFromDeg(3.0);
constexpr double kSurelyOffSigmas = 4.0;
// For a search over all directions. Shadows explain 0.01 to 0.02 of the differences in overcast
// pictures, 0.03 and more in sunlit ones. A sun within some degrees of the best explains most of
// that.
constexpr double kLeastExplained = 0.025;
constexpr double kLeastShareOfExplained = 0.3;
// Under a recording's own sun at least 0.83 of the pixels look as it has them; stripes of paving,
// under the sun whose shadows fit them best, 0.6.
constexpr double kLeastAgreement = 0.8;
// What shade has of its light comes from the sky. Under clouds corners are dark, too, and may fit
// some sun's shadows, but no bluer. A logarithm.
constexpr double kLeastBlueness = 0.04;
// Of the search itself: of the elevation, which nothing later refines.
constexpr double kSearchStddevRad = RadFromDeg(3.0);
constexpr double kSurelyOffRad = kSurelyOffSigmas * kSearchStddevRad;

// The angle at the sun that a turn about the vertical makes.
double AtSun(const glm::dvec3& sun_enu, double azimuth_rad) {
  return azimuth_rad * std::hypot(sun_enu.x, sun_enu.y);
}

double AzimuthBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::abs(std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y));
}

std::size_t Lowest(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin());
}

// The factor by which frames scatter around their common offset more than each of them thinks (the
// Birge ratio); at least 1.
double FrameDisagreement(const ShadowDirectionResult& result) {
  double chi_squared = 0.0;
  int count = 0;
  for (const FrameShadowDirection& frame : result.frames) {
    if (!frame.shadow.determined) continue;
    const double z =
        (frame.shadow.azimuth_offset_rad - result.all.azimuth_offset_rad) / frame.shadow.stddev_rad;
    chi_squared += z * z;
    ++count;
  }
  return count < 2 ? 1.0 : std::sqrt(std::max(1.0, chi_squared / (count - 1)));
}

}  // namespace

void ShadowDirectionOptions::Validate() const {
  if (!(largest_offset_rad > 0.0) || !(largest_offset_rad <= std::numbers::pi)) {
    throw std::invalid_argument("largest_offset_rad " + std::to_string(largest_offset_rad) +
                                ": expected above 0, to pi");
  }
  if (!(step_rad > 0.0) || !(step_rad <= largest_offset_rad)) {
    throw std::invalid_argument("step_rad " + std::to_string(step_rad) +
                                ": expected above 0, to largest_offset_rad");
  }
  if (pixels < 100) {
    throw std::invalid_argument("pixels " + std::to_string(pixels) + ": expected 100 or more");
  }
  if (frames < 1) {
    throw std::invalid_argument("frames " + std::to_string(frames) + ": expected 1 or more");
  }
}

bool ShadowDirection::ContradictsTheSun() const {
  const double off_rad = std::abs(azimuth_offset_rad);
  return determined && off_rad > kClearlyOffSigmas * stddev_rad && off_rad > kClearlyOffRad;
}

struct ShadowDirectionFinder::Impl {
  Mesh mesh;
  std::vector<std::uint8_t> usable;
  ShadowDirectionOptions options;
  OffsetGrid grid;
  RayCaster caster;
  std::optional<Camera> camera;  // The camera that `surfaces` are for.
  std::vector<ShadowPixel> surfaces;

  struct Picture {
    int frame = 0;
    glm::dvec3 sun_direction_enu{0.0};
    ShadowPicture pixels;
  };
  std::vector<Picture> pictures;
  std::size_t added = 0;
  std::size_t every = 1;  // One in so many of the added frames is kept.

  Impl(Mesh mesh_in, std::span<const std::string> regions, const ShadowDirectionOptions& options_in)
      : mesh(std::move(mesh_in)),
        usable(UsableTriangles(mesh, regions)),
        options(options_in),
        caster(mesh) {
    options.Validate();
    grid.step_rad = options.step_rad;
    grid.half = static_cast<int>(std::floor(options.largest_offset_rad / options.step_rad + 1e-6));
  }

  void KeepEveryOther() {
    std::vector<Picture> kept;
    for (std::size_t i = 0; i < pictures.size(); i += 2) kept.push_back(std::move(pictures[i]));
    pictures = std::move(kept);
    every *= 2;
  }

  const std::vector<ShadowPixel>& SurfacesOf(const Camera& of, const std::stop_token& stop) {
    if (camera != of) {
      surfaces = FindShadowPixels({mesh, usable, caster}, of, options.pixels, stop);
      camera = of;
      if (stop.stop_requested()) camera.reset();  // They may be incomplete.
    }
    return surfaces;
  }

  Picture MakePicture(const Frame& frame,
                      const glm::dvec3& sun_direction_enu,
                      const std::stop_token& stop) {
    Picture picture;
    picture.frame = frame.index;
    picture.sun_direction_enu = sun_direction_enu;
    const double elevation_rad =
        std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
    if (elevation_rad >= kLeastElevationRad && elevation_rad <= kLargestElevationRad) {
      picture.pixels = MakeShadowPicture(frame, SurfacesOf(frame.camera, stop));
    }
    picture.pixels.candidates = grid.Size();
    picture.pixels.shares =
        SharesOfSun(picture.pixels.surface, caster, sun_direction_enu, grid, stop);
    return picture;
  }

  std::size_t BestByMisfit(const std::vector<Picture>& pictures_in) const {
    std::vector<double> misfit(grid.Size(), 0.0);
    for (const Picture& picture : pictures_in) {
      const std::vector<double> one = MisfitByCandidate(picture.pixels);
      for (std::size_t k = 0; k < misfit.size(); ++k) misfit[k] += one[k];
    }
    return Lowest(misfit);
  }

  PictureEvidence Evidence(const Picture& picture,
                           std::size_t candidate,
                           const std::stop_token& stop) const {
    const glm::dvec3& sun = picture.sun_direction_enu;
    const double elevation_rad = std::atan2(sun.z, std::hypot(sun.x, sun.y));
    std::vector<std::vector<std::uint8_t>> shares;
    for (int k = -kRaisedSteps; k <= kRaisedSteps; ++k) {
      const double raised_rad = elevation_rad + k * kRaisedStepRad;
      if (raised_rad < kLeastRaisedElevationRad || raised_rad > kLargestRaisedElevationRad)
        continue;
      if (k == 0) {
        shares.push_back(picture.pixels.shares);
        continue;
      }
      const double widen = std::cos(raised_rad) / std::hypot(sun.x, sun.y);
      shares.push_back(SharesOfSun(picture.pixels.surface,
                                   caster,
                                   {sun.x * widen, sun.y * widen, std::sin(raised_rad)},
                                   grid,
                                   stop));
    }
    if (shares.empty()) shares.push_back(picture.pixels.shares);
    return EvidenceNear(picture.pixels, candidate, shares);
  }

  ShadowDirection Judge(const OffsetEstimate& estimate, std::size_t tiles) const {
    ShadowDirection shadow;
    shadow.azimuth_offset_rad = estimate.offset_rad;
    shadow.curvature_stddev_rad = estimate.curvature_stddev_rad;
    shadow.spread_stddev_rad = estimate.spread_stddev_rad;
    shadow.stddev_rad = std::max(shadow.curvature_stddev_rad, shadow.spread_stddev_rad);
    const double reach_rad = std::abs(shadow.azimuth_offset_rad) + 3.0 * shadow.stddev_rad;
    if (tiles == 0) {
      shadow.reason = "no surface shows sun and shade clearly apart";
    } else if (tiles < kLeastTiles) {
      shadow.reason = "hardly any shadow's edge is in view";
    } else if (shadow.stddev_rad > kLargestStddevRad) {
      shadow.reason = "several directions explain the pictures equally well";
    } else if (reach_rad > options.largest_offset_rad) {
      shadow.reason = "the best direction is at the end of the range searched";
    } else if (shadow.spread_stddev_rad > kLargestStddevRatio * shadow.curvature_stddev_rad) {
      shadow.reason = "parts of the pictures contradict each other";
    } else {
      shadow.determined = true;
    }
    return shadow;
  }

  ShadowDirectionResult ResultOf(const std::vector<Picture>& of,
                                 const std::stop_token& stop) const {
    std::size_t best = BestByMisfit(of);
    std::vector<PictureEvidence> evidence;
    OffsetPosterior posterior;
    std::size_t tiles = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      evidence.clear();
      std::vector<OffsetUnit> units;
      for (std::size_t f = 0; f < of.size(); ++f) {
        evidence.push_back(Evidence(of[f], best, stop));
        for (TileEvidence& tile : evidence.back().tiles) {
          const std::size_t row = tile.tile / 1000 / kTilesPerBlock;
          const std::size_t column = tile.tile % 1000 / kTilesPerBlock;
          units.push_back({f, 1000 * row + column, std::move(tile.log_likelihood)});
        }
      }
      tiles = units.size();
      posterior = CombineUnits(units, of.size(), grid);
      if (posterior.peak == best) break;
      best = posterior.peak;
    }
    ShadowDirectionResult result;
    result.all = Judge(posterior.all, tiles);
    for (std::size_t f = 0; f < of.size(); ++f) {
      FrameShadowDirection frame;
      frame.frame = of[f].frame;
      frame.sunlit = evidence[f].sunlit;
      frame.contrast = evidence[f].contrast;
      frame.tiles = evidence[f].tiles.size();
      frame.shadow = Judge(posterior.frames[f], frame.tiles);
      result.frames.push_back(std::move(frame));
    }
    result.all.stddev_rad *= FrameDisagreement(result);
    if (result.all.determined && result.all.stddev_rad > kLargestStddevRad) {
      result.all.determined = false;
      result.all.reason = "the frames contradict each other";
    }
    return result;
  }
};

ShadowDirectionFinder::ShadowDirectionFinder(Mesh mesh,
                                             std::span<const std::string> diffuse_regions,
                                             const ShadowDirectionOptions& options)
    : impl_(std::make_unique<Impl>(std::move(mesh), diffuse_regions, options)) {}
ShadowDirectionFinder::~ShadowDirectionFinder() = default;
ShadowDirectionFinder::ShadowDirectionFinder(ShadowDirectionFinder&&) noexcept = default;
ShadowDirectionFinder& ShadowDirectionFinder::operator=(ShadowDirectionFinder&&) noexcept = default;

void ShadowDirectionFinder::Add(const Frame& frame, const glm::dvec3& sun_direction_enu) {
  Impl& impl = *impl_;
  if (impl.added++ % impl.every != 0) return;
  impl.pictures.push_back(impl.MakePicture(frame, sun_direction_enu, {}));
  if (impl.pictures.size() > static_cast<std::size_t>(impl.options.frames)) impl.KeepEveryOther();
}

ShadowDirectionResult ShadowDirectionFinder::Result() const {
  return impl_->ResultOf(impl_->pictures, {});
}

ShownSun ShadowDirectionFinder::ShownBy(const Frame& frame, const glm::dvec3& stated_sun_enu) {
  return *ShownBy(frame, stated_sun_enu, {});
}

std::optional<ShownSun> ShadowDirectionFinder::ShownBy(const Frame& frame,
                                                       const glm::dvec3& stated_sun_enu,
                                                       const std::stop_token& stop) {
  Impl& impl = *impl_;
  ShownSun shown;
  shown.direction_enu = stated_sun_enu;
  const SunSearch search = SearchSun(MakeShadowPicture(frame, impl.SurfacesOf(frame.camera, stop)),
                                     impl.caster,
                                     stated_sun_enu,
                                     stop);
  if (stop.stop_requested()) return std::nullopt;
  if (!(search.explained >= kLeastExplained)) return shown;
  shown.near_stated = impl.ResultOf({impl.MakePicture(frame, stated_sun_enu, stop)}, stop).all;
  if (stop.stop_requested()) return std::nullopt;
  const ShadowDirection& near = shown.near_stated;
  if (near.determined &&
      search.explained_near_stated >= kLeastShareOfExplained * search.explained) {
    shown.direction_enu = TurnedClockwise(stated_sun_enu, near.azimuth_offset_rad);
    shown.stddev_rad = AtSun(stated_sun_enu, near.stddev_rad);
    shown.contradicts = std::abs(near.azimuth_offset_rad) >=
                        std::max(kWorthAWarningRad, kSurelyOffSigmas * near.stddev_rad);
    return shown;
  }
  // At the end of the range about the stated sun, or where the search of all directions found it.
  const bool at_the_end = near.stddev_rad > 0.0 && near.stddev_rad <= kLargestStddevRad &&
                          std::abs(near.azimuth_offset_rad) > 0.5 * impl.options.largest_offset_rad;
  std::vector<glm::dvec3> middles;
  if (search.agreement >= kLeastAgreement) middles.push_back(search.direction_enu);
  if (at_the_end) {
    middles.insert(middles.begin(), TurnedClockwise(stated_sun_enu, near.azimuth_offset_rad));
  }
  for (const glm::dvec3& middle : middles) {
    const Impl::Picture picture = impl.MakePicture(frame, middle, stop);
    const ShadowDirection there = impl.ResultOf({picture}, stop).all;
    if (stop.stop_requested()) return std::nullopt;
    if (!there.determined) continue;
    const std::size_t candidate = impl.grid.Nearest(there.azimuth_offset_rad);
    if (!(BluenessOfShade(picture.pixels, candidate) >= kLeastBlueness)) continue;
    shown.direction_enu = TurnedClockwise(middle, there.azimuth_offset_rad);
    const bool is_searched = middle == search.direction_enu;
    shown.stddev_rad =
        std::hypot(AtSun(middle, there.stddev_rad), is_searched ? kSearchStddevRad : 0.0);
    shown.contradicts = AzimuthBetween(shown.direction_enu, stated_sun_enu) >=
                            std::max(kWorthAWarningRad, kSurelyOffSigmas * there.stddev_rad) ||
                        AngleBetweenRad(shown.direction_enu, stated_sun_enu) >= kSurelyOffRad;
    break;
  }
  return shown;
}

}  // namespace pleinair
