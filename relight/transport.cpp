#include "relight/transport.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/internal/low_discrepancy.h"
#include "relight/internal/sun_disc.h"

namespace pleinair {
namespace {

// Points on a patch that are tried for the sun.
constexpr int kSunPointsPerPatch = 6;
// A receiver's batch is stored on its own, so that rays are cast without a common lock and joined
// in order. Large enough to hide the scheduling, small enough to spread over many cores.
constexpr std::size_t kReceiversPerBatch = 64;

// Upper hemisphere to the unit diamond, turned by 45 deg to fill a square of 16-bit steps.
std::uint32_t PackUpperDirection(const glm::vec3& direction) {
  const float scale =
      1.0f / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  const float x = direction.x * scale;
  const float y = direction.y * scale;
  const auto quantise = [](float value) {
    return static_cast<std::uint32_t>(
        std::lround((glm::clamp(value, -1.0f, 1.0f) * 0.5f + 0.5f) * 65535.0f));
  };
  return (quantise(x + y) << 16) | quantise(x - y);
}

glm::vec3 UnpackUpperDirection(std::uint32_t packed) {
  const float u = static_cast<float>(packed >> 16) * (2.0f / 65535.0f) - 1.0f;
  const float v = static_cast<float>(packed & 0xffffu) * (2.0f / 65535.0f) - 1.0f;
  // A direction that was above the horizon stays above it.
  const float z = std::max(1.0f - std::max(std::abs(u), std::abs(v)), 1e-6f);
  return glm::normalize(glm::vec3(0.5f * (u + v), 0.5f * (u - v), z));
}

void CheckFaceCount(std::size_t given, std::size_t expected, const char* what) {
  if (given != expected) {
    throw std::invalid_argument(std::string(what) + " has " + std::to_string(given) +
                                " faces: expected " + std::to_string(expected));
  }
}

bool IsUnit(const glm::vec3& normal) { return std::abs(glm::dot(normal, normal) - 1.0f) < 1e-3f; }

}  // namespace

void GatherOptions::Validate() const {
  if (rays_per_receiver < 1 || rays_per_receiver > 65536) {
    throw std::invalid_argument("rays_per_receiver is " + std::to_string(rays_per_receiver) +
                                ": expected 1 to 65536");
  }
}

template <class RayOrigin>
void GatheredRays::Gather(const PatchScene& scene,
                          std::size_t receiver_count,
                          const GatherOptions& options,
                          const RayOrigin& ray_origin) {
  options.Validate();
  rays_per_receiver_ = options.rays_per_receiver;
  const float share = 1.0f / static_cast<float>(options.rays_per_receiver);

  struct Batch {
    std::vector<std::uint32_t> face_count;
    std::vector<std::uint32_t> sky_count;
    std::vector<std::int32_t> face;
    std::vector<float> face_share;
    std::vector<std::uint32_t> sky;
  };
  std::vector<Batch> batches((receiver_count + kReceiversPerBatch - 1) / kReceiversPerBatch);
  tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t b) {
    Batch& batch = batches[b];
    std::vector<std::int32_t> hits;
    const std::size_t end = std::min(receiver_count, (b + 1) * kReceiversPerBatch);
    for (std::size_t i = b * kReceiversPerBatch; i < end; ++i) {
      const std::size_t faces_before = batch.face.size();
      const std::size_t skies_before = batch.sky.size();
      const glm::vec3 normal = ray_origin.Normal(i);
      if (IsUnit(normal)) {
        hits.clear();
        const NormalFrame frame(normal);
        const glm::dvec2 rotation = RotationOf(options.seed, i);
        for (int k = 0; k < options.rays_per_receiver; ++k) {
          const glm::vec3 direction =
              frame.CosineDirection(FibonacciPoint(k, options.rays_per_receiver, rotation));
          const glm::vec3 origin = ray_origin.Origin(i, k, rotation);
          if (const auto hit = scene.caster.Intersect(origin, direction)) {
            hits.push_back(PatchScene::FaceOfHit(*hit, direction));
          } else if (direction.z > 0.0f) {
            batch.sky.push_back(PackUpperDirection(direction));
          }
        }
        std::sort(hits.begin(), hits.end());
        for (std::size_t first = 0; first < hits.size();) {
          std::size_t last = first;
          while (last < hits.size() && hits[last] == hits[first]) ++last;
          batch.face.push_back(hits[first]);
          batch.face_share.push_back(share * static_cast<float>(last - first));
          first = last;
        }
      }
      batch.face_count.push_back(static_cast<std::uint32_t>(batch.face.size() - faces_before));
      batch.sky_count.push_back(static_cast<std::uint32_t>(batch.sky.size() - skies_before));
    }
  });

  face_begin_.assign(1, 0);
  sky_begin_.assign(1, 0);
  for (Batch& batch : batches) {
    for (const std::uint32_t count : batch.face_count) {
      face_begin_.push_back(face_begin_.back() + count);
    }
    for (const std::uint32_t count : batch.sky_count) {
      sky_begin_.push_back(sky_begin_.back() + count);
    }
  }
  face_.reserve(face_begin_.back());
  face_share_.reserve(face_begin_.back());
  sky_direction_.reserve(sky_begin_.back());
  for (Batch& batch : batches) {
    face_.insert(face_.end(), batch.face.begin(), batch.face.end());
    face_share_.insert(face_share_.end(), batch.face_share.begin(), batch.face_share.end());
    sky_direction_.insert(sky_direction_.end(), batch.sky.begin(), batch.sky.end());
    batch = Batch{};
  }
}

GatheredRays::GatheredRays(const PatchScene& scene,
                           std::span<const Receiver> receivers,
                           const GatherOptions& options) {
  struct AtPoint {
    std::span<const Receiver> receivers;
    glm::vec3 Normal(std::size_t i) const { return receivers[i].normal; }
    glm::vec3 Origin(std::size_t i, int, const glm::dvec2&) const {
      return OffsetFromSurface(receivers[i].position_m, receivers[i].normal);
    }
  };
  Gather(scene, receivers.size(), options, AtPoint{receivers});
}

GatheredRays GatheredRays::OfFaces(const PatchScene& scene, const GatherOptions& options) {
  struct OnFace {
    const PatchScene& scene;
    glm::vec3 Normal(std::size_t face) const { return scene.FaceNormal(face); }
    glm::vec3 Origin(std::size_t face, int ray, const glm::dvec2& rotation) const {
      const glm::uvec3& v = scene.mesh.triangles[face / 2];
      const glm::vec3 point = TrianglePoint(scene.mesh.positions_m[v[0]],
                                            scene.mesh.positions_m[v[1]],
                                            scene.mesh.positions_m[v[2]],
                                            R2Point(ray, {rotation.y, rotation.x}));
      return OffsetFromSurface(point, scene.FaceNormal(face));
    }
  };
  GatheredRays rays;
  rays.Gather(scene, scene.FaceCount(), options, OnFace{scene});
  return rays;
}

std::vector<glm::vec3> GatheredRays::FromSky(const SkyShape& shape) const {
  std::vector<glm::vec3> irradiance(ReceiverCount(), glm::vec3(0.0f));
  const double scale = std::numbers::pi / rays_per_receiver_;
  tbb::parallel_for(std::size_t{0}, irradiance.size(), [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    for (std::uint64_t k = sky_begin_[i]; k < sky_begin_[i + 1]; ++k) {
      sum += glm::dvec3(shape.Radiance(UnpackUpperDirection(sky_direction_[k])));
    }
    irradiance[i] = glm::vec3(scale * sum);
  });
  return irradiance;
}

glm::vec3 GatheredRays::FromFacesAt(std::size_t receiver,
                                    std::span<const glm::vec3> face_radiosity) const {
  glm::vec3 sum(0.0f);
  for (std::uint64_t k = face_begin_[receiver]; k < face_begin_[receiver + 1]; ++k) {
    sum += face_share_[k] * face_radiosity[static_cast<std::size_t>(face_[k])];
  }
  return sum;
}

std::vector<glm::vec3> GatheredRays::FromFaces(std::span<const glm::vec3> face_radiosity) const {
  std::vector<glm::vec3> irradiance(ReceiverCount());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, irradiance.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        irradiance[i] = FromFacesAt(i, face_radiosity);
                      }
                    });
  return irradiance;
}

std::vector<GatheredRays::FaceShare> GatheredRays::FacesOf(std::size_t receiver) const {
  std::vector<FaceShare> faces;
  for (std::uint64_t k = face_begin_[receiver]; k < face_begin_[receiver + 1]; ++k) {
    faces.push_back({face_[k], face_share_[k]});
  }
  return faces;
}

double GatheredRays::SkyShareOf(std::size_t receiver) const {
  return static_cast<double>(sky_begin_[receiver + 1] - sky_begin_[receiver]) / rays_per_receiver_;
}

float SunVisibility(const RayCaster& caster,
                    const Receiver& receiver,
                    const glm::dvec3& sun_direction_enu,
                    double sun_angular_radius_rad,
                    int samples) {
  return SunDisc(sun_direction_enu, sun_angular_radius_rad, samples).Visibility(caster, receiver);
}

PatchTransport::PatchTransport(const PatchScene& scene, const GatherOptions& options)
    : face_rays_(GatheredRays::OfFaces(scene, options)) {}

std::vector<glm::vec3> PatchTransport::DirectFromSun(const PatchScene& scene,
                                                     const glm::dvec3& sun_direction_enu,
                                                     double sun_angular_radius_rad) const {
  const SunDisc disc(sun_direction_enu, sun_angular_radius_rad, kSunPointsPerPatch);
  std::vector<glm::vec3> irradiance(scene.FaceCount(), glm::vec3(0.0f));
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, scene.mesh.triangles.size(), 256),
      [&](const tbb::blocked_range<std::size_t>& range) {
        std::vector<glm::vec3> points(kSunPointsPerPatch);
        for (std::size_t patch = range.begin(); patch < range.end(); ++patch) {
          const glm::uvec3& v = scene.mesh.triangles[patch];
          // The same places on every patch: a fixed set has no noise, and a patch half in shadow
          // gets about half.
          for (int i = 0; i < kSunPointsPerPatch; ++i) {
            points[static_cast<std::size_t>(i)] = TrianglePoint(scene.mesh.positions_m[v[0]],
                                                                scene.mesh.positions_m[v[1]],
                                                                scene.mesh.positions_m[v[2]],
                                                                R2Point(i, {0.5, 0.5}));
          }
          const glm::vec3 normal = scene.FaceNormal(2 * patch);
          const float towards = glm::dot(normal, disc.Direction());
          // The disc may be cut by the patch's own plane, so the side away from its centre is
          // looked at too, close to grazing.
          const auto margin = static_cast<float>(std::sin(sun_angular_radius_rad));
          if (towards > -margin) {
            irradiance[2 * patch] = glm::vec3(disc.MeanIrradiance(scene.caster, points, normal));
          }
          if (towards < margin) {
            irradiance[2 * patch + 1] =
                glm::vec3(disc.MeanIrradiance(scene.caster, points, -normal));
          }
        }
      });
  return irradiance;
}

FaceLight PatchTransport::SolveSky(const PatchScene& scene,
                                   const SkyShape& shape,
                                   int bounces) const {
  CheckFaceCount(scene.FaceCount(), face_rays_.ReceiverCount(), "scene");
  return Solve(scene, DirectFromSky(shape), bounces);
}

FaceLight PatchTransport::SolveSun(const PatchScene& scene,
                                   const glm::dvec3& sun_direction_enu,
                                   double sun_angular_radius_rad,
                                   int bounces) const {
  CheckFaceCount(scene.FaceCount(), face_rays_.ReceiverCount(), "scene");
  return Solve(scene, DirectFromSun(scene, sun_direction_enu, sun_angular_radius_rad), bounces);
}

FaceLight PatchTransport::Solve(const PatchScene& scene,
                                std::span<const glm::vec3> direct_irradiance,
                                int bounces) const {
  const std::size_t faces = face_rays_.ReceiverCount();
  CheckFaceCount(scene.FaceCount(), faces, "scene");
  CheckFaceCount(direct_irradiance.size(), faces, "direct_irradiance");
  CheckFaceCount(scene.face_albedo_rgb.size(), faces, "face_albedo_rgb");
  if (bounces < kAllBounces) {
    throw std::invalid_argument("bounces is " + std::to_string(bounces) +
                                ": expected a count >= 0, or -1 for all");
  }
  FaceLight light;
  light.radiosity.assign(faces, glm::vec3(0.0f));
  if (bounces == 0) return light;

  const std::vector<glm::vec3>& albedo = scene.face_albedo_rgb;
  for (std::size_t i = 0; i < faces; ++i) light.radiosity[i] = albedo[i] * direct_irradiance[i];
  light.iterations = 1;

  // What later iterations would add is change * q / (1 - q), q the ratio of successive changes.
  // With albedo 0.98 all around, q is 0.98 and 1e-6 takes some 700 iterations.
  constexpr double kMissing = 1e-6;
  constexpr int kMaxIterations = 5000;
  const int last = bounces == kAllBounces ? kMaxIterations : bounces;
  std::vector<glm::vec3> next(faces);
  constexpr std::size_t kBlock = 512;
  const std::size_t blocks = (faces + kBlock - 1) / kBlock;
  std::vector<glm::vec2> block_maxima(blocks);  // Largest change, largest radiosity.
  double previous_change = 0.0;
  while (light.iterations < last) {
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
      glm::vec2 maxima(0.0f);
      for (std::size_t i = block * kBlock; i < std::min(faces, (block + 1) * kBlock); ++i) {
        next[i] = albedo[i] * (direct_irradiance[i] + face_rays_.FromFacesAt(i, light.radiosity));
        for (int channel = 0; channel < 3; ++channel) {
          maxima.x = std::max(maxima.x, std::abs(next[i][channel] - light.radiosity[i][channel]));
          maxima.y = std::max(maxima.y, next[i][channel]);
        }
      }
      block_maxima[block] = maxima;
    });
    light.radiosity.swap(next);
    ++light.iterations;
    glm::vec2 maxima(0.0f);
    for (const glm::vec2& block : block_maxima) maxima = glm::max(maxima, block);
    const double change = maxima.y > 0.0f ? static_cast<double>(maxima.x) / maxima.y : 0.0;
    if (bounces == kAllBounces) {
      light.residual = change;
      const double q = previous_change > 0.0 ? std::min(change / previous_change, 0.999) : 0.5;
      // Below float's step nothing changes any more.
      if (change * q / (1.0 - q) < kMissing || change < 1e-7) break;
    }
    previous_change = change;
  }
  return light;
}

}  // namespace pleinair
