#include "relight/volume/probe_operator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>

#include <tbb/parallel_for.h>
#include <cereal/archives/binary.hpp>
#include <cereal/archives/portable_binary.hpp>
#include <cereal/types/vector.hpp>

#include "relight/volume/internal/probe_rays.h"
#include "relight/volume/internal/probe_stand.h"
#include "scene/is_finite.h"
#include "scene/sphere_directions.h"

namespace pleinair {
namespace {

using internal::ProbeRays;
using internal::RayCounts;
using internal::SourceLayout;

constexpr int kMostRaysPerProbe = 1 << 24;
constexpr char kAxisNames[] = "xyz";

std::size_t MapPixels(const Survey* survey) {
  if (survey == nullptr) return 0;
  const SurfaceView& view = survey->view;
  const std::size_t pixels = view.region.pixels.size();
  const auto require = [&](std::size_t size, const char* name) {
    if (size == pixels) return;
    throw std::invalid_argument("survey view: " + std::string(name) + " has " +
                                std::to_string(size) + " pixels, expected the map's " +
                                std::to_string(pixels));
  };
  require(static_cast<std::size_t>(view.Width()) * static_cast<std::size_t>(view.Height()),
          "region's width x height");
  require(view.position_world_m.pixels.size(), "position_world_m");
  require(view.normal_world.pixels.size(), "normal_world");
  require(view.albedo_measured.pixels.size(), "albedo_measured");
  if (pixels == 0) throw std::invalid_argument("survey view: the map has no pixels");
  return pixels;
}

// The least spacing between neighbours; of a single probe, the grid's stated one.
float LeastSpacing(const ProbeGrid& grid) {
  return std::min({grid.spacing_m.x, grid.spacing_m.y, grid.spacing_m.z});
}

// Casts from each clear stand of a probe and keeps the one that sees the most sky, or else the most
// fronts. Of the two sides of a sheet that is the outside, however the sheet is wound.
std::optional<glm::vec3> CastProbe(const ProbeRays& rays,
                                   std::span<const glm::vec3> clear_stands_m,
                                   std::span<std::uint32_t> sources,
                                   RayCounts& counts) {
  std::optional<glm::vec3> best;
  std::vector<std::uint32_t> tried(sources.size());
  for (const glm::vec3& stand : clear_stands_m) {
    const RayCounts seen = rays.Cast(stand, tried);
    if (best && std::tie(seen.sky, seen.front) <= std::tie(counts.sky, counts.front)) continue;
    best = stand;
    counts = seen;
    std::copy(tried.begin(), tried.end(), sources.begin());
  }
  return best;
}

}  // namespace

glm::vec3 ProbeGrid::PositionM(std::size_t probe) const {
  const auto columns = static_cast<std::size_t>(counts.x);
  const auto rows = static_cast<std::size_t>(counts.y);
  return lower_m +
         spacing_m * glm::vec3(probe % columns, probe / columns % rows, probe / (columns * rows));
}

void ProbeGrid::Validate() const {
  if (!IsFinite(lower_m)) throw std::invalid_argument("probe grid: lower_m is not finite");
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, kAxisNames[axis]);
    if (counts[axis] < 1) {
      throw std::invalid_argument("probe grid: counts." + name + " is " +
                                  std::to_string(counts[axis]) + ", expected at least 1");
    }
    if (!(spacing_m[axis] > 0.0f) || !std::isfinite(spacing_m[axis])) {
      throw std::invalid_argument("probe grid: spacing_m." + name + " is " +
                                  std::to_string(spacing_m[axis]) +
                                  ", expected a positive length in metres");
    }
  }
}

ProbeGrid MakeProbeGrid(const BoundingBox& box, glm::ivec3 counts) {
  const glm::vec3 extent_m = box.upper_m - box.lower_m;
  ProbeGrid grid;
  grid.counts = counts;
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    if (!(extent_m[axis] >= 0.0f) || !std::isfinite(extent_m[axis])) {
      throw std::invalid_argument(std::string("probe box: from ") +
                                  std::to_string(box.lower_m[axis]) + " to " +
                                  std::to_string(box.upper_m[axis]) + " m along " +
                                  kAxisNames[axis] + ", expected finite lower <= upper");
    }
    if (extent_m[axis] == 0.0f && counts[axis] > 1) grid.counts[axis] = 1;
    if (grid.counts[axis] > 1) {
      grid.lower_m[axis] = box.lower_m[axis];
      grid.spacing_m[axis] = extent_m[axis] / static_cast<float>(grid.counts[axis] - 1);
    } else {
      grid.lower_m[axis] = box.lower_m[axis] + 0.5f * extent_m[axis];
      // Nothing is interpolated along this axis: any length will do that fits the box.
      if (extent_m[axis] > 0.0f) grid.spacing_m[axis] = extent_m[axis];
    }
  }
  grid.Validate();
  return grid;
}

void ProbeOptions::Validate() const {
  if (rays_per_probe < 1 || rays_per_probe > kMostRaysPerProbe) {
    throw std::invalid_argument("rays_per_probe is " + std::to_string(rays_per_probe) +
                                ", expected 1 to " + std::to_string(kMostRaysPerProbe));
  }
}

ProbeOperator::ProbeOperator(const PatchScene& scene,
                             const Survey* survey,
                             const ProbeGrid& grid,
                             const ProbeOptions& options)
    : grid_(grid) {
  grid.Validate();
  options.Validate();
  MakeDirections(options.rays_per_probe + options.rays_per_probe % 2, options.seed);
  const std::size_t pixels = MapPixels(survey);
  const std::size_t count = pixels + scene.FaceCount() + sky_directions_.size();
  if (count >= SourceLayout::kDark) {
    throw std::invalid_argument("probe operator: " + std::to_string(count) +
                                " map pixels, faces and sky directions, expected below 2^32 - 1");
  }
  map_pixels_ = static_cast<std::uint32_t>(pixels);
  faces_ = static_cast<std::uint32_t>(scene.FaceCount());
  const SourceLayout layout{
      map_pixels_, faces_, static_cast<std::uint32_t>(sky_directions_.size())};

  const std::size_t probes = grid.ProbeCount();
  sources_.assign(probes * RayCount(), SourceLayout::kDark);
  const ProbeRays rays(scene, survey, directions_, layout);
  std::vector<std::optional<glm::vec3>> stands_m(probes);
  std::vector<RayCounts> counts(probes);
  tbb::parallel_for(std::size_t{0}, probes, [&](std::size_t probe) {
    stands_m[probe] =
        CastProbe(rays,
                  internal::ClearStands(scene.caster, grid.PositionM(probe), LeastSpacing(grid)),
                  std::span(sources_).subspan(probe * RayCount(), RayCount()),
                  counts[probe]);
  });
  valid_ = internal::InFreeAir(scene.caster, grid, stands_m, counts, static_cast<int>(RayCount()));
  for (std::size_t probe = 0; probe < probes; ++probe) {
    if (valid_[probe] != 0) continue;
    std::fill_n(sources_.begin() + static_cast<std::ptrdiff_t>(probe * RayCount()),
                RayCount(),
                SourceLayout::kDark);
  }
}

void ProbeOperator::MakeDirections(int rays_per_probe, std::uint64_t seed) {
  seed_ = seed;
  directions_ = internal::SphereDirections(rays_per_probe, seed);
  sky_directions_.assign(directions_.begin(), directions_.begin() + rays_per_probe / 2);
  const auto solid_angle_sr = static_cast<float>(4.0 * std::numbers::pi / rays_per_probe);
  ray_weights_.assign(directions_.size(), RayWeights{});
  for (std::size_t ray = 0; ray < directions_.size(); ++ray) {
    const std::array<float, kProbeShCoefficients> basis = EvaluateShBasis9(directions_[ray]);
    for (std::size_t j = 0; j < basis.size(); ++j) ray_weights_[ray][j] = basis[j] * solid_angle_sr;
  }
}

std::vector<ShRgb> ProbeOperator::Apply(
    std::span<const glm::vec3> environment,
    std::span<const glm::vec3> face_radiosity,
    std::span<const glm::vec3> sky_radiance_of_directions) const {
  const auto require = [](std::size_t size, std::size_t expected, const char* name) {
    if (size == 0 || size == expected) return;
    throw std::invalid_argument("probe operator: " + std::string(name) + " has " +
                                std::to_string(size) + " entries, expected " +
                                std::to_string(expected) + " or none");
  };
  require(environment.size(), map_pixels_, "environment");
  require(face_radiosity.size(), faces_, "face_radiosity");
  require(sky_radiance_of_directions.size(), sky_directions_.size(), "sky_radiance_of_directions");

  // Faces, open sky and nothing in one table behind the map's pixels: then which of the two holds a
  // ray's light is a choice between pointers, and the loop over rays has no branch.
  std::vector<glm::vec3> rest(std::size_t{faces_} + sky_directions_.size() + 1, glm::vec3(0.0f));
  for (std::size_t face = 0; face < face_radiosity.size(); ++face) {
    rest[face] = face_radiosity[face] / std::numbers::pi_v<float>;
  }
  std::copy(
      sky_radiance_of_directions.begin(), sky_radiance_of_directions.end(), rest.begin() + faces_);
  const auto dark = static_cast<std::uint32_t>(rest.size() - 1);
  const std::vector<glm::vec3> black_map(environment.empty() ? map_pixels_ : 0, glm::vec3(0.0f));
  const glm::vec3* const map = environment.empty() ? black_map.data() : environment.data();

  // Single precision within a run of this many rays, double over the runs: the rounding error of
  // 1024 terms stays that of 32.
  constexpr std::size_t kRun = 32;
  std::vector<ShRgb> coefficients(grid_.ProbeCount());
  tbb::parallel_for(std::size_t{0}, valid_.size(), [&](std::size_t probe) {
    const std::uint32_t* const sources = sources_.data() + probe * RayCount();
    std::array<std::array<double, 12>, 3> total{};
    for (std::size_t begin = 0; begin < RayCount(); begin += kRun) {
      std::array<std::array<float, 12>, 3> run{};
      const std::size_t end = std::min(begin + kRun, RayCount());
      for (std::size_t ray = begin; ray < end; ++ray) {
        const std::uint32_t source = sources[ray];
        const glm::vec3& light =
            *(source < map_pixels_ ? map + source
                                   : rest.data() + std::min(source - map_pixels_, dark));
        const RayWeights& weights = ray_weights_[ray];
        for (std::size_t j = 0; j < 12; ++j) run[0][j] += light.x * weights[j];
        for (std::size_t j = 0; j < 12; ++j) run[1][j] += light.y * weights[j];
        for (std::size_t j = 0; j < 12; ++j) run[2][j] += light.z * weights[j];
      }
      for (std::size_t channel = 0; channel < 3; ++channel) {
        for (std::size_t j = 0; j < 12; ++j) total[channel][j] += run[channel][j];
      }
    }
    for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
      coefficients[probe][j] = glm::vec3(total[0][j], total[1][j], total[2][j]);
    }
  });
  return coefficients;
}

template <class Archive>
void ProbeOperator::serialize(Archive& archive) {
  auto rays = static_cast<std::uint32_t>(RayCount());
  archive(grid_.lower_m.x, grid_.lower_m.y, grid_.lower_m.z);
  archive(grid_.spacing_m.x, grid_.spacing_m.y, grid_.spacing_m.z);
  archive(grid_.counts.x, grid_.counts.y, grid_.counts.z);
  archive(rays, seed_, map_pixels_, faces_, valid_, sources_);
  if constexpr (Archive::is_loading::value) {
    grid_.Validate();
    // A default-made operator has neither rays nor probes, and may be stored as well.
    const std::size_t probes = rays == 0 ? 0 : grid_.ProbeCount();
    const std::size_t count = std::size_t{map_pixels_} + faces_ + rays / 2;
    bool sound = rays % 2 == 0 && rays <= static_cast<std::uint32_t>(kMostRaysPerProbe) &&
                 valid_.size() == probes && sources_.size() == probes * rays;
    for (const std::uint32_t source : sources_) {
      sound = sound && (source < count || source == SourceLayout::kDark);
    }
    if (!sound) throw std::runtime_error("stored probe operator: sizes do not fit together");
    MakeDirections(static_cast<int>(rays), seed_);
  }
}

template void ProbeOperator::serialize(cereal::BinaryInputArchive&);
template void ProbeOperator::serialize(cereal::BinaryOutputArchive&);
template void ProbeOperator::serialize(cereal::PortableBinaryInputArchive&);
template void ProbeOperator::serialize(cereal::PortableBinaryOutputArchive&);

}  // namespace pleinair
