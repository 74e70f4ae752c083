#include "relight/transport/transport.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/transport/internal/radiosity_solver.h"
#include "relight/transport/sun_disc.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// Points on a patch that are tried for the sun.
constexpr int kSunPointsPerPatch = 6;

void CheckFaceCount(std::size_t given, std::size_t expected, const char* what) {
  if (given != expected) {
    throw std::invalid_argument(std::string(what) + " has " + std::to_string(given) +
                                " faces: expected " + std::to_string(expected));
  }
}

}  // namespace

float SunVisibility(const RayCaster& caster,
                    const Receiver& receiver,
                    const glm::dvec3& sun_direction_enu,
                    double sun_angular_radius_rad,
                    int samples) {
  return SunDisc(sun_direction_enu, sun_angular_radius_rad, samples).Visibility(caster, receiver);
}

PatchTransport::PatchTransport(const PatchScene& scene, const GatherOptions& options)
    : face_rays_(options.from_exposed_parts
                     ? GatheredRays::OfExposedFaces(scene, options, face_points_)
                     : GatheredRays::OfFaces(scene, options)) {}

std::vector<glm::vec3> PatchTransport::DirectFromSun(const PatchScene& scene,
                                                     const glm::dvec3& sun_direction_enu,
                                                     double sun_angular_radius_rad) const {
  const bool exposed = face_points_.FaceCount() == scene.FaceCount();
  const SunDisc disc(
      sun_direction_enu, sun_angular_radius_rad, exposed ? FacePoints::kCells : kSunPointsPerPatch);
  std::vector<glm::vec3> irradiance(scene.FaceCount(), glm::vec3(0.0f));
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, scene.FaceCount(), 512),
      [&](const tbb::blocked_range<std::size_t>& range) {
        std::vector<Receiver> points;
        for (std::size_t face = range.begin(); face < range.end(); ++face) {
          points.clear();
          if (exposed) {
            const glm::vec3 normal = scene.FaceNormal(face);
            for (const glm::vec3& point_m : face_points_.Of(face)) {
              points.push_back({point_m, normal});
            }
          } else {
            // The same places on every patch: a fixed set has no noise, and a patch half in shadow
            // gets about half. Not so on joined patches, whose triangles face several ways: those
            // that have the fixed places would count for all patches' others.
            const glm::dvec2 rotation = scene.IsJoined(face / 2)
                                            ? RotationOf(kSunPointsPerPatch, face / 2)
                                            : glm::dvec2(0.5);
            for (int i = 0; i < kSunPointsPerPatch; ++i) {
              const auto [position_m, triangle] = scene.PointOn(face / 2, R2Point(i, rotation));
              points.push_back({position_m, scene.SideNormal(2 * triangle + face % 2)});
            }
          }
          irradiance[face] = glm::vec3(disc.MeanIrradiance(scene.caster, points));
        }
      });
  return irradiance;
}

FaceLight PatchTransport::SolveSun(const PatchScene& scene,
                                   const glm::dvec3& sun_direction_enu,
                                   double sun_angular_radius_rad,
                                   int bounces) const {
  CheckFaceCount(scene.FaceCount(), face_rays_.ReceiverCount(), "scene");
  std::vector<glm::vec3> direct = DirectFromSun(scene, sun_direction_enu, sun_angular_radius_rad);
  FaceLight light = Solve(scene, direct, bounces);
  light.direct_irradiance = std::move(direct);
  return light;
}

std::vector<FaceLight> PatchTransport::SolveTogether(
    const PatchScene& scene,
    std::span<const std::shared_ptr<const SkyShape>> skies,
    const std::optional<Sun>& sun,
    int bounces) const {
  CheckFaceCount(scene.FaceCount(), face_rays_.ReceiverCount(), "scene");
  std::vector<const SkyShape*> shapes;
  for (const auto& sky : skies) shapes.push_back(sky.get());
  std::vector<std::vector<glm::vec3>> direct_of_light = face_rays_.FromSkies(shapes);
  if (sun) {
    direct_of_light.push_back(DirectFromSun(scene, sun->direction_enu, sun->angular_radius_rad));
  }
  const std::size_t lights = direct_of_light.size();
  if (lights == 0) return {};
  std::vector<glm::vec3> direct(scene.FaceCount() * lights);
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    for (std::size_t light = 0; light < lights; ++light) {
      direct[face * lights + light] = direct_of_light[light][face];
    }
  }
  SolveOptions options;
  options.bounces = bounces;
  const FaceLights solved = SolveBlocks(scene, direct, lights, options);
  std::vector<FaceLight> split;
  for (std::size_t light = 0; light < lights; ++light) {
    split.push_back({solved.OfLight(light), solved.iterations, solved.residual, {}});
  }
  if (sun) split.back().direct_irradiance = std::move(direct_of_light.back());
  return split;
}

FaceLight PatchTransport::Solve(const PatchScene& scene,
                                std::span<const glm::vec3> direct_irradiance,
                                int bounces) const {
  SolveOptions options;
  options.bounces = bounces;
  FaceLights lights = SolveBlocks(scene, direct_irradiance, 1, options);
  return {std::move(lights.radiosity), lights.iterations, lights.residual, {}};
}

FaceLights PatchTransport::SolveMany(const PatchScene& scene,
                                     std::span<const glm::vec3> direct_irradiance,
                                     std::size_t lights,
                                     const SolveOptions& options) const {
  FaceLights solved = SolveBlocks(scene, direct_irradiance, lights, options);
  if (options.bounces != 0) solved.energy_error = EnergyError(scene, solved);
  return solved;
}

FaceLights PatchTransport::SolveBlocks(const PatchScene& scene,
                                       std::span<const glm::vec3> direct_irradiance,
                                       std::size_t lights,
                                       const SolveOptions& options) const {
  options.Validate();
  const std::size_t faces = face_rays_.ReceiverCount();
  CheckFaceCount(scene.FaceCount(), faces, "scene");
  CheckFaceCount(scene.face_albedo_rgb.size(), faces, "face_albedo_rgb");
  if (lights < 1 || direct_irradiance.size() != faces * lights) {
    throw std::invalid_argument("direct_irradiance has " +
                                std::to_string(direct_irradiance.size()) + " entries: expected " +
                                std::to_string(faces) + " faces x " + std::to_string(lights) +
                                " lights, one light at least");
  }
  FaceLights solved;
  solved.lights = lights;
  solved.radiosity.assign(faces * lights, glm::vec3(0.0f));
  if (options.bounces == 0) return solved;

  const internal::FormFactorRows rows{
      face_rays_.face_begin_, face_rays_.face_, face_rays_.face_share_};
  for (std::size_t first = 0; first < lights; first += internal::kLightsPerBlock) {
    const std::size_t count = std::min(internal::kLightsPerBlock, lights - first);
    if (options.progress) {
      options.progress("radiosity", static_cast<double>(first) / static_cast<double>(lights));
    }
    const internal::BlockSolution block =
        internal::SolveBlock(rows,
                             scene.face_albedo_rgb,
                             {direct_irradiance, lights, first, count},
                             {options.bounces, options.tolerance},
                             solved.radiosity);
    solved.iterations = std::max(solved.iterations, block.iterations);
    solved.residual = std::max(solved.residual, block.residual);
  }
  if (options.progress) options.progress("radiosity", 1.0);
  return solved;
}

// Arrived at face i: A_i sum_j F_ij B_j; sent by face i: A_i B_i sum_j F_ij.
double PatchTransport::EnergyError(const PatchScene& scene, const FaceLights& solved) const {
  const std::size_t lights = solved.lights;
  std::vector<double> weight(solved.FaceCount(), 0.0);  // By which face j's radiosity arrives.
  std::vector<double> sent_weight(solved.FaceCount(), 0.0);
  for (std::size_t i = 0; i < solved.FaceCount(); ++i) {
    const double share = face_points_.FaceCount() == 0 ? 1.0 : face_points_.ExposedShareOf(i);
    const double area_m2 = share * scene.PatchAreaM2(i / 2);
    for (std::uint64_t k = face_rays_.face_begin_[i]; k < face_rays_.face_begin_[i + 1]; ++k) {
      weight[static_cast<std::size_t>(face_rays_.face_[k])] += area_m2 * face_rays_.face_share_[k];
      sent_weight[i] += area_m2 * face_rays_.face_share_[k];
    }
  }
  std::vector<glm::dvec2> sums(lights, glm::dvec2(0.0));  // Arrived, sent; of all channels.
  for (std::size_t i = 0; i < solved.FaceCount(); ++i) {
    for (std::size_t light = 0; light < lights; ++light) {
      const glm::vec3& rgb = solved.radiosity[i * lights + light];
      const double radiosity = double{rgb.x} + double{rgb.y} + double{rgb.z};
      sums[light] += radiosity * glm::dvec2(weight[i], sent_weight[i]);
    }
  }
  double worst = 0.0;
  for (const glm::dvec2& sum : sums) {
    if (sum.y > 0.0) worst = std::max(worst, std::abs(sum.x - sum.y) / sum.y);
  }
  return worst;
}

std::vector<glm::vec3> FaceLights::OfLight(std::size_t light) const {
  std::vector<glm::vec3> of_light;
  of_light.reserve(FaceCount());
  for (std::size_t i = light; i < radiosity.size(); i += lights) of_light.push_back(radiosity[i]);
  return of_light;
}

void SolveOptions::Validate() const {
  if (bounces < kAllBounces) {
    throw std::invalid_argument("bounces is " + std::to_string(bounces) +
                                ": expected a count >= 0, or -1 for all");
  }
  if (!(tolerance > 0.0) || !(tolerance < 1.0)) {
    throw std::invalid_argument("tolerance is " + std::to_string(tolerance) +
                                ": expected a share in (0, 1)");
  }
}

std::size_t RadiosityBytes(std::size_t patches,
                           std::size_t lights,
                           const GatherOptions& options,
                           std::size_t sky_directions) {
  const std::size_t faces = 2 * patches;
  const auto rays = static_cast<std::size_t>(options.rays_per_receiver + FacePoints::kCells);
  // While rays are gathered each has a face and a direction; afterwards an entry of 8 bytes, or a
  // packed direction. Both forms exist for a moment.
  const std::size_t of_rays = faces * rays * (sizeof(std::int32_t) + sizeof(glm::vec3) + 8);
  const std::size_t of_sky = faces * (sky_directions / 8 + 8);
  // The sky's share of each region, direct light and radiosity of all lights, and a block's two.
  const std::size_t of_lights =
      faces * (lights * (sizeof(float) + 2 * sizeof(glm::vec3)) +
               2 * std::min(lights, internal::kLightsPerBlock) * sizeof(glm::vec3));
  return of_rays + of_sky + of_lights;
}

}  // namespace pleinair
