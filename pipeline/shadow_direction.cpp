#include "pipeline/shadow_direction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "pipeline/internal/offset_posterior.h"
#include "pipeline/internal/shadow_evidence.h"
#include "pipeline/internal/shadow_pixels.h"
#include "scene/ray_caster.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// A tile is this share of the picture's width: large enough for a shadow's edge and both its
// sides, small against what a passing car covers.
constexpr int kTilesAcross = 16;
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
// Two ways to know the uncertainty that differ by more than this speak of two different answers.
constexpr double kLargestStddevRatio = 6.0;
constexpr double kClearlyOffRad = RadFromDeg(0.5);
constexpr double kClearlyOffSigmas = 3.0;

std::vector<std::uint8_t> UsableTriangles(const Mesh& mesh, std::span<const std::string> regions) {
  if (mesh.Empty()) throw std::invalid_argument("mesh: expected triangles");
  std::vector<std::uint8_t> usable(mesh.triangles.size(), regions.empty() ? 1 : 0);
  for (const std::string& name : regions) {
    bool found = false;
    for (std::size_t i = 0; i < usable.size(); ++i) {
      if (mesh.group_names[mesh.triangle_group[i]] != name &&
          mesh.materials[mesh.triangle_material[i]].name != name) {
        continue;
      }
      usable[i] = 1;
      found = true;
    }
    if (!found) {
      throw std::invalid_argument("diffuse_regions: \"" + name +
                                  "\" is no group or material of the mesh");
    }
  }
  return usable;
}

double Luminance(const glm::vec3& rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

// A clipped pixel is at least as bright as it says: surely lit where lit and shaded differ.
bool MayBeUsed(const Frame& frame, std::size_t pixel) {
  if (frame.unusable.Empty() || frame.unusable.pixels[pixel] == 0) return true;
  return !frame.clipped.Empty() && frame.clipped.pixels[pixel] != 0;
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
  if (!(largest_offset_rad > 0.0) || !(largest_offset_rad <= std::numbers::pi / 2.0)) {
    throw std::invalid_argument("largest_offset_rad " + std::to_string(largest_offset_rad) +
                                ": expected above 0, to pi/2");
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
  std::optional<Camera> camera;  // What `surfaces` were found for.
  std::vector<ShadowPixel> surfaces;

  struct Picture {
    int frame = 0;
    glm::dvec3 sun_direction_enu{0.0};
    ShadowPicture pixels;
  };
  std::vector<Picture> pictures;
  std::size_t added = 0;
  std::size_t every = 1;  // Of the frames added, so many to one that is kept.

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

  std::size_t BestByMisfit() const {
    std::vector<double> misfit(grid.Size(), 0.0);
    for (const Picture& picture : pictures) {
      const std::vector<double> one = MisfitByCandidate(picture.pixels);
      for (std::size_t k = 0; k < misfit.size(); ++k) misfit[k] += one[k];
    }
    return Lowest(misfit);
  }

  PictureEvidence Evidence(const Picture& picture, std::size_t candidate) const {
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
                                   grid));
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
      shadow.reason = "several directions explain the pictures alike";
    } else if (reach_rad > options.largest_offset_rad) {
      shadow.reason = "the best direction is at the end of the range searched";
    } else if (shadow.spread_stddev_rad > kLargestStddevRatio * shadow.curvature_stddev_rad) {
      shadow.reason = "parts of the pictures contradict each other";
    } else {
      shadow.determined = true;
    }
    return shadow;
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
  if (impl.camera != frame.camera) {
    impl.surfaces =
        FindShadowPixels(impl.mesh, impl.usable, impl.caster, frame.camera, impl.options.pixels);
    impl.camera = frame.camera;
  }
  Impl::Picture picture;
  picture.frame = frame.index;
  picture.pixels.grid = impl.grid;
  const double elevation_rad =
      std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
  if (elevation_rad >= kLeastElevationRad && elevation_rad <= kLargestElevationRad) {
    const int tile_px = std::max(1, frame.radiance.width / kTilesAcross);
    for (const ShadowPixel& surface : impl.surfaces) {
      const std::size_t i = frame.radiance.Index(surface.x, surface.y);
      const double luminance = Luminance(frame.radiance.pixels[i]);
      if (!MayBeUsed(frame, i) || !(luminance > 0.0) || !std::isfinite(luminance)) continue;
      picture.pixels.surface.push_back(surface);
      picture.pixels.log_radiance.push_back(std::log(luminance));
      picture.pixels.plane.push_back(surface.plane);
      picture.pixels.tile.push_back(
          static_cast<std::uint32_t>(1000 * (surface.y / tile_px) + surface.x / tile_px));
    }
  }
  picture.sun_direction_enu = sun_direction_enu;
  picture.pixels.shares =
      SharesOfSun(picture.pixels.surface, impl.caster, sun_direction_enu, impl.grid);
  impl.pictures.push_back(std::move(picture));
  if (impl.pictures.size() > static_cast<std::size_t>(impl.options.frames)) impl.KeepEveryOther();
}

ShadowDirectionResult ShadowDirectionFinder::Result() const {
  const Impl& impl = *impl_;
  std::size_t best = impl.BestByMisfit();
  std::vector<PictureEvidence> evidence;
  OffsetPosterior posterior;
  std::size_t tiles = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    evidence.clear();
    std::vector<OffsetUnit> units;
    for (std::size_t f = 0; f < impl.pictures.size(); ++f) {
      evidence.push_back(impl.Evidence(impl.pictures[f], best));
      for (TileEvidence& tile : evidence.back().tiles) {
        const std::size_t row = tile.tile / 1000 / kTilesPerBlock;
        const std::size_t column = tile.tile % 1000 / kTilesPerBlock;
        units.push_back({f, 1000 * row + column, std::move(tile.log_likelihood)});
      }
    }
    tiles = units.size();
    posterior = CombineUnits(units, impl.pictures.size(), impl.grid);
    if (posterior.peak == best) break;
    best = posterior.peak;
  }
  ShadowDirectionResult result;
  result.all = impl.Judge(posterior.all, tiles);
  for (std::size_t f = 0; f < impl.pictures.size(); ++f) {
    FrameShadowDirection frame;
    frame.frame = impl.pictures[f].frame;
    frame.sunlit = evidence[f].sunlit;
    frame.contrast = evidence[f].contrast;
    frame.tiles = evidence[f].tiles.size();
    frame.shadow = impl.Judge(posterior.frames[f], frame.tiles);
    result.frames.push_back(std::move(frame));
  }
  result.all.stddev_rad *= FrameDisagreement(result);
  if (result.all.determined && result.all.stddev_rad > kLargestStddevRad) {
    result.all.determined = false;
    result.all.reason = "the frames contradict each other";
  }
  return result;
}

}  // namespace pleinair
