// The one transport engine: how receivers respond to unit basis lights. Ray hits are stored once;
// every basis light, bounce and albedo is then a sum over them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/patch_scene.h"
#include "relight/sky_shape.h"

namespace pleinair {

inline constexpr int kAllBounces = -1;

// A point on a surface that gathers light over the hemisphere around its normal.
struct Receiver {
  glm::vec3 position_m{0.0f};
  glm::vec3 normal{0.0f, 0.0f, 1.0f};  // Unit, to the side that gathers.
};

struct GatherOptions {
  int rays_per_receiver =
      256;  // Cosine-distributed, low-discrepancy. Converged: as many as wished.
  std::uint64_t seed = 1;
};

// What receivers see: per receiver the faces hit, and the directions that reach the sky.
// The result does not depend on the number of threads.
class GatheredRays {
 public:
  GatheredRays() = default;
  GatheredRays(const PatchScene& scene,
               std::span<const Receiver> receivers,
               const GatherOptions& options);

  std::size_t ReceiverCount() const;
  // Irradiance at each receiver straight from the sky (c, for a uniform shape).
  std::vector<glm::vec3> FromSky(const SkyShape& shape) const;
  // Irradiance at each receiver from faces of given radiosity.
  std::vector<glm::vec3> FromFaces(std::span<const glm::vec3> face_radiosity) const;

  template <class Archive>
  void serialize(Archive& archive);

 private:
  // Per receiver i the entries [face_begin_[i], face_begin_[i + 1]): each face once, with its share
  // of rays.
  std::vector<std::uint32_t> face_begin_;
  std::vector<std::int32_t> face_;
  std::vector<float> face_share_;
  // Per receiver the directions that reach the sky; each carries 1 / rays_per_receiver.
  std::vector<std::uint32_t> sky_begin_;
  std::vector<glm::vec3> sky_direction_;
  int rays_per_receiver_ = 1;
};

// Radiosity (W m^-2 per unit of irradiance) of every face for one unit basis light.
struct FaceLight {
  std::vector<glm::vec3> radiosity;
  int iterations = 0;
  double residual = 0.0;  // Largest relative change in the last iteration.
};

// Share of the sun's disc that is seen from a point, 0..1, from `samples` rays spread over the
// disc.
float SunVisibility(const RayCaster& caster,
                    const Receiver& receiver,
                    const glm::dvec3& sun_direction_enu,
                    double sun_angular_radius_rad,
                    int samples);

// Light between the patches of a scene.
class PatchTransport {
 public:
  PatchTransport() = default;
  PatchTransport(const PatchScene& scene, const GatherOptions& options);

  // `bounces` counts reflections on the way to a receiver: 0 leaves every face dark, 1 has faces
  // reflect direct light only, kAllBounces iterates to convergence.
  FaceLight SolveSky(const PatchScene& scene, const SkyShape& shape, int bounces) const;
  FaceLight SolveSun(const PatchScene& scene,
                     const glm::dvec3& sun_direction_enu,
                     double sun_angular_radius_rad,
                     int bounces) const;

  template <class Archive>
  void serialize(Archive& archive);

 private:
  FaceLight Solve(const PatchScene& scene,
                  std::vector<glm::vec3> direct_irradiance,
                  int bounces) const;
  GatheredRays face_rays_;
};

}  // namespace pleinair
