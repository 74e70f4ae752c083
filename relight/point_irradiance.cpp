#include "relight/point_irradiance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/internal/content_hash.h"
#include "relight/internal/serialization.h"
#include "relight/internal/sphere_gather.h"
#include "relight/internal/stored_stages.h"
#include "relight/transport/patch_refinement.h"
#include "relight/transport/region_radiosity.h"
#include "relight/transport/sun_disc.h"
#include "scene/is_finite.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// Rays over the disc: from a given point, and from a ray's hit, of which there are thousands.
constexpr int kSunSamplesAtPoint = 256;
constexpr int kSunSamplesAtHit = 1;

constexpr double kTolerance = 1e-5;
// Part of every key: to be raised when what a radiosity is made of, or its stored form, changes.
constexpr std::string_view kRadiosityFormat = "pleinair-radiosity-1";

void CheckPoints(std::span<const glm::vec3> points_m, std::span<const glm::vec3> normals) {
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!IsFinite(points_m[i])) {
      throw std::invalid_argument("points[" + std::to_string(i) + "] is not finite");
    }
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!(std::abs(glm::length(normals[i]) - 1.0f) < 1e-3f)) {
      throw std::invalid_argument("normals[" + std::to_string(i) + "] has length " +
                                  std::to_string(glm::length(normals[i])) + ": expected 1");
    }
  }
}

PatchOptions FocusOn(std::span<const glm::vec3> points_m, double growth_per_m) {
  PatchOptions options;
  options.extend_ground = false;
  options.join_small = false;  // Its light starts from parts of triangles.
  options.growth_per_m = growth_per_m;
  options.focus_points_m.assign(points_m.begin(), points_m.end());
  return options;
}

// The shortest patches that stay within the budget, to 5 %. A mesh that has more triangles than
// that already is left nearly as it is.
double ShortestPatchSizeM(const Mesh& mesh, PatchOptions options, std::size_t budget) {
  if (mesh.Empty()) return 1.0;
  const BoundingBox box = BoundingBoxOf(mesh);
  const double longest_m =
      std::max(1e-6, glm::distance(glm::dvec3(box.lower_m), glm::dvec3(box.upper_m)));
  const auto fits = [&](double size_m) {
    options.patch_size_m = size_m;
    return FitsPatchBudget(mesh, options, budget);
  };
  double fitting = longest_m;
  double too_short = longest_m;
  do {
    fitting = too_short;
    too_short *= 0.5;
  } while (too_short > 1e-6 * longest_m && fits(too_short));
  while (fitting / too_short > 1.05) {
    const double middle = std::sqrt(fitting * too_short);
    (fits(middle) ? fitting : too_short) = middle;
  }
  return fitting;
}

std::vector<glm::vec3> Grey(std::span<const float> values) {
  std::vector<glm::vec3> grey;
  grey.reserve(values.size());
  for (const float value : values) grey.emplace_back(value);
  return grey;
}

void AddTo(std::vector<glm::vec3>& sum, std::span<const glm::vec3> terms) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += terms[i];
}

void AddTo(std::vector<ShRgb>& sum, std::span<const ShRgb> terms) {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    for (std::size_t k = 0; k < sum[i].size(); ++k) sum[i][k] += terms[i][k];
  }
}

bool HasDirect(LightPart part) { return part != LightPart::kIndirect; }
bool HasIndirect(LightPart part) { return part != LightPart::kDirect; }

}  // namespace

// Null radiance: unit radiance of each region.
struct PointIrradiance::Sky {
  const SkyRegions& regions;
  const SkyRadiance* radiance = nullptr;

  std::size_t Lights() const { return radiance == nullptr ? regions.Count() : 1; }

  std::shared_ptr<const SkyDirections> Directions(int rays, std::uint64_t seed) const {
    // A sky that is one light is cut into regions all the same, for its rays to be spread well.
    const SkyRegions cut = radiance == nullptr && regions.Count() > 1 ? regions : SkyRegions();
    const auto count = static_cast<int>(cut.Count());
    return std::make_shared<SkyDirections>(cut, std::max(1, rays / count), seed);
  }

  std::vector<glm::vec3> Irradiance(const SkyVisibility& visibility,
                                    const SkyDirections& directions) const {
    if (radiance == nullptr && regions.Count() > 1) return Grey(visibility.FromRegions());
    std::vector<glm::vec3> values;
    if (radiance == nullptr) values.assign(directions.Directions().size(), glm::vec3(1.0f));
    if (radiance == nullptr) return visibility.FromRadiance(values);
    values.reserve(directions.Directions().size());
    for (const glm::vec3& direction : directions.Directions()) {
      values.push_back((*radiance)(direction));
    }
    return visibility.FromRadiance(values);
  }

  internal::SphereGather::SkyRay RayOf(const glm::vec3& direction) const {
    if (radiance != nullptr) return {0, (*radiance)(direction)};
    return {regions.RegionOf(glm::dvec3(direction)).value_or(0), glm::vec3(1.0f)};
  }
};

void PointIrradianceOptions::Validate() const {
  const auto refuse = [](const char* field, double value, const char* expected) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                ": expected " + expected);
  };
  if (bounces < kAllBounces) refuse("bounces", bounces, "a count >= 0, or -1 for all");
  if (!(patch_size_m >= 0.0) || !std::isfinite(patch_size_m)) {
    refuse("patch_size_m", patch_size_m, "a length > 0, or 0 for the shortest");
  }
  if (!(patch_growth_per_m >= 0.0) || !std::isfinite(patch_growth_per_m)) {
    refuse("patch_growth_per_m", patch_growth_per_m, "a ratio >= 0");
  }
  const auto check_rays = [&](const char* field, int rays, int most) {
    if (rays < 1 || rays > most) {
      refuse(field, rays, ("1 to " + std::to_string(most)).c_str());
    }
  };
  check_rays("rays_per_point", rays_per_point, 65536);
  check_rays("sky_rays_per_point", sky_rays_per_point, SkyDirections::kMostDirections);
  check_rays("sky_rays_per_patch", sky_rays_per_patch, SkyDirections::kMostDirections);
  check_rays("rays_per_patch", rays_per_patch, 65536);
}

PointIrradiance::PointIrradiance(const Mesh& mesh,
                                 AskedPoints asked,
                                 const PointIrradianceOptions& options,
                                 Progress progress,
                                 BlobStore* store)
    : points_m_(std::move(asked.points_m)),
      normals_(std::move(asked.normals)),
      options_(options),
      progress_(std::move(progress)),
      store_(store) {
  options_.Validate();
  CheckPoints(points_m_, normals_);
  PatchOptions patches = FocusOn(points_m_, options_.patch_growth_per_m);
  patches.patch_size_m =
      options_.patch_size_m > 0.0
          ? options_.patch_size_m
          : ShortestPatchSizeM(mesh, patches, PointIrradianceOptions::kPatchBudget);
  patches.ground_albedo = options_.ground_albedo;
  patches_ = BuildPatchScene(mesh, patches);

  summary_.patches = patches_.PatchCount();
  summary_.memory_bytes = RadiosityBytes(summary_.patches,
                                         options_.regions.Count(),
                                         PatchGather(),
                                         static_cast<std::size_t>(options_.sky_rays_per_patch));
}

GatherOptions PointIrradiance::PatchGather() const {
  return {.rays_per_receiver = options_.rays_per_patch,
          .seed = options_.seed,
          .from_exposed_parts = true};
}

GatherOptions PointIrradiance::PointGather() const {
  return {.rays_per_receiver = options_.rays_per_point, .seed = options_.seed + 1};
}

std::vector<Receiver> PointIrradiance::Receivers() const {
  std::vector<Receiver> receivers;
  for (const glm::vec3& point : points_m_) {
    for (const glm::vec3& normal : normals_) receivers.push_back({point, glm::normalize(normal)});
  }
  return receivers;
}

void PointIrradiance::Report(std::string_view stage, double share) const {
  if (progress_) progress_(stage, share);
}

const PatchTransport& PointIrradiance::Transport() {
  if (!transport_) {
    Report("rays between patches", 0.0);
    transport_ = std::make_unique<PatchTransport>(patches_, PatchGather());
    const FacePoints& points = transport_->Points();
    for (std::size_t face = 0; face < points.FaceCount(); ++face) {
      summary_.exposed_faces += points.Of(face).empty() ? 0 : 1;
    }
    Report("rays between patches", 1.0);
  }
  return *transport_;
}

SolveOptions PointIrradiance::SolveSettings() const {
  SolveOptions options;
  options.bounces = options_.bounces;
  options.tolerance = kTolerance;
  options.progress = progress_;
  return options;
}

void PointIrradiance::Summarise(const FaceLights& solved) {
  summary_.iterations = solved.iterations;
  summary_.residual = solved.residual;
  summary_.energy_error = solved.energy_error;
}

FaceLights PointIrradiance::Solve(std::span<const glm::vec3> direct, std::size_t lights) {
  FaceLights solved = Transport().SolveMany(patches_, direct, lights, SolveSettings());
  Summarise(solved);
  return solved;
}

// All that the radiosity of a sky follows from.
std::string PointIrradiance::KeyOf(const Sky& sky) const {
  internal::ContentHash hash;
  hash.Add(kRadiosityFormat).AddAll(patches_.mesh.positions_m).AddAll(patches_.mesh.triangles);
  hash.AddAll(patches_.face_albedo_rgb);
  hash.Add(options_.rays_per_patch).Add(options_.sky_rays_per_patch).Add(options_.seed);
  hash.Add(sky.regions.Bands()).Add(sky.regions.Sectors());
  hash.Add(options_.bounces).Add(kTolerance);
  return hash.Hex();
}

FaceLights PointIrradiance::SolveRegions() {
  RegionRadiosityOptions options;
  options.regions = options_.regions;
  options.sky_rays_per_patch = options_.sky_rays_per_patch;
  options.seed = options_.seed;
  options.solve = SolveSettings();
  options.ranks = options_.ranks;
  const PatchTransport& transport = Transport();
  FaceLights solved = pleinair::SolveRegions(patches_, transport, options);
  Summarise(solved);
  return solved;
}

FaceLights PointIrradiance::SolveSky(const Sky& sky) {
  FaceLights lights;
  const auto solve = [&] {
    if (sky.radiance == nullptr && sky.regions.Count() > 1) {
      lights = SolveRegions();
      return;
    }
    const PatchTransport& transport = Transport();
    Report("sky over patches", 0.0);
    const auto directions = sky.Directions(options_.sky_rays_per_patch, options_.seed);
    const auto visibility = SkyVisibility::OfFaces(patches_, transport.Points(), directions);
    const std::vector<glm::vec3> direct = sky.Irradiance(visibility, *directions);
    Report("sky over patches", 1.0);
    lights = Solve(direct, sky.Lights());
  };
  // A sky that is a function has no content that a key could be made of; ranks that find a part in
  // their stores, or don't, would no longer make the same calls.
  if (store_ == nullptr || sky.radiance != nullptr || options_.ranks != nullptr) {
    solve();
    return lights;
  }
  const auto parts = [&](auto& archive) {
    archive(lights.lights, summary_.exposed_faces);
    archive(summary_.iterations, summary_.residual, summary_.energy_error);
    internal::ArchiveBlock(archive, lights.radiosity);
  };
  const Progress silent;
  internal::StoredStages(*store_, silent).Run("radiosity", KeyOf(sky), solve, parts);
  return lights;
}

std::vector<glm::vec3> PointIrradiance::FromSurfaces(std::span<const Receiver> receivers,
                                                     const FaceLights& lights) const {
  return GatheredRays(patches_, receivers, PointGather())
      .FromFaces(lights.radiosity, lights.lights);
}

std::vector<glm::vec3> PointIrradiance::OfSky(const Sky& sky, LightPart part) {
  const std::vector<Receiver> receivers = Receivers();
  std::vector<glm::vec3> irradiance(receivers.size() * sky.Lights(), glm::vec3(0.0f));
  if (HasDirect(part)) {
    Report("sky over points", 0.0);
    const auto directions = sky.Directions(options_.sky_rays_per_point, options_.seed);
    const SkyVisibility visibility(patches_, receivers, directions);
    AddTo(irradiance, sky.Irradiance(visibility, *directions));
    Report("sky over points", 1.0);
  }
  if (HasIndirect(part) && options_.bounces != 0) {
    const FaceLights lights = SolveSky(sky);
    Report("rays from points", 0.0);
    AddTo(irradiance, FromSurfaces(receivers, lights));
    Report("rays from points", 1.0);
  }
  return irradiance;
}

std::vector<ShRgb> PointIrradiance::ShOfSky(const Sky& sky, LightPart part) {
  std::vector<ShRgb> coefficients(points_m_.size() * sky.Lights(), ShRgb{});
  Report("rays from points", 0.0);
  const internal::SphereGather sphere(
      patches_, points_m_, 2 * options_.rays_per_point, options_.seed + 1);
  Report("rays from points", 1.0);
  if (HasDirect(part)) {
    AddTo(coefficients,
          sphere.FromSky([&](const glm::vec3& direction) { return sky.RayOf(direction); },
                         sky.Lights()));
  }
  if (HasIndirect(part) && options_.bounces != 0) {
    const FaceLights lights = SolveSky(sky);
    AddTo(coefficients, sphere.FromFaces(lights.radiosity, lights.lights));
  }
  return coefficients;
}

std::vector<glm::vec3> PointIrradiance::OfRegions(LightPart part) {
  return OfSky(Sky{options_.regions}, part);
}

std::vector<glm::vec3> PointIrradiance::OfSky(const SkyRadiance& radiance, LightPart part) {
  return OfSky(Sky{options_.regions, &radiance}, part);
}

std::vector<ShRgb> PointIrradiance::ShOfRegions(LightPart part) {
  return ShOfSky(Sky{options_.regions}, part);
}

std::vector<ShRgb> PointIrradiance::ShOfSky(const SkyRadiance& radiance, LightPart part) {
  return ShOfSky(Sky{options_.regions, &radiance}, part);
}

// The sun's part of what surfaces send. It is looked up where a ray meets the surface, so that a
// sunlit spot has its own edge and not a patch's border.
std::vector<glm::vec3> PointIrradiance::SunByWayOfOneSurface(const glm::dvec3& direction_enu,
                                                             double angular_radius_rad) const {
  const SunDisc disc(direction_enu, angular_radius_rad, kSunSamplesAtHit);
  const std::vector<Receiver> receivers = Receivers();
  const GatherOptions gather = PointGather();
  std::vector<glm::vec3> irradiance(receivers.size(), glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, receivers.size(), [&](std::size_t i) {
    const NormalFrame frame(receivers[i].normal);
    const glm::vec3 origin = OffsetFromSurface(receivers[i].position_m, receivers[i].normal);
    const glm::dvec2 rotation = RotationOf(gather.seed, i);
    glm::dvec3 sum(0.0);
    for (int k = 0; k < gather.rays_per_receiver; ++k) {
      const glm::vec3 direction =
          frame.CosineDirection(FibonacciPoint(k, gather.rays_per_receiver, rotation));
      const auto hit = patches_.caster.Intersect(origin, direction);
      if (!hit) continue;
      const auto face = static_cast<std::size_t>(patches_.FaceOfHit(*hit, direction));
      const Receiver at_hit{hit->position_m,
                            face % 2 == 0 ? hit->geometric_normal : -hit->geometric_normal};
      const float cosine = glm::dot(at_hit.normal, disc.Direction());
      if (!(cosine > 0.0f)) continue;
      sum += glm::dvec3(patches_.face_albedo_rgb[face]) *
             double{cosine * disc.Visibility(patches_.caster, at_hit)};
    }
    irradiance[i] = glm::vec3(sum / static_cast<double>(gather.rays_per_receiver));
  });
  return irradiance;
}

std::vector<glm::vec3> PointIrradiance::OfSun(const glm::dvec3& direction_enu,
                                              double angular_radius_rad,
                                              LightPart part) {
  const std::vector<Receiver> receivers = Receivers();
  std::vector<glm::vec3> irradiance(receivers.size(), glm::vec3(0.0f));
  if (HasDirect(part)) {
    const SunDisc disc(direction_enu, angular_radius_rad, kSunSamplesAtPoint);
    tbb::parallel_for(std::size_t{0}, receivers.size(), [&](std::size_t i) {
      const float cosine = glm::dot(receivers[i].normal, disc.Direction());
      irradiance[i] =
          glm::vec3(std::max(0.0f, cosine) * disc.Visibility(patches_.caster, receivers[i]));
    });
  }
  if (HasIndirect(part) && options_.bounces != 0) {
    const PatchTransport& transport = Transport();
    const std::vector<glm::vec3> direct =
        transport.DirectFromSun(patches_, direction_enu, angular_radius_rad);
    FaceLights lights = Solve(direct, 1);
    for (std::size_t face = 0; face < direct.size(); ++face) {
      lights.radiosity[face] -= patches_.face_albedo_rgb[face] * direct[face];
    }
    Report("rays from points", 0.0);
    AddTo(irradiance, FromSurfaces(receivers, lights));
    AddTo(irradiance, SunByWayOfOneSurface(direction_enu, angular_radius_rad));
    Report("rays from points", 1.0);
  }
  return irradiance;
}

std::vector<ShRgb> PointIrradiance::ShOfSun(const glm::dvec3& direction_enu,
                                            double angular_radius_rad,
                                            LightPart part) {
  std::vector<ShRgb> coefficients(points_m_.size(), ShRgb{});
  if (HasDirect(part)) {
    const SunDisc disc(direction_enu, angular_radius_rad, kSunSamplesAtPoint);
    const auto basis = EvaluateShBasis9(disc.Direction());
    for (std::size_t i = 0; i < points_m_.size(); ++i) {
      const float seen = disc.Visibility(patches_.caster, {points_m_[i], disc.Direction()});
      for (std::size_t k = 0; k < basis.size(); ++k) {
        coefficients[i][k] = glm::vec3(seen * basis[k]);
      }
    }
  }
  if (HasIndirect(part) && options_.bounces != 0) {
    const FaceLights lights =
        Solve(Transport().DirectFromSun(patches_, direction_enu, angular_radius_rad), 1);
    Report("rays from points", 0.0);
    const internal::SphereGather sphere(
        patches_, points_m_, 2 * options_.rays_per_point, options_.seed + 1);
    AddTo(coefficients, sphere.FromFaces(lights.radiosity, 1));
    Report("rays from points", 1.0);
  }
  return coefficients;
}

}  // namespace pleinair
