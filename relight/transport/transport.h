// The one transport engine: how receivers respond to unit basis lights. Ray hits are stored once;
// every basis light, bounce and albedo is then a sum over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/progress.h"
#include "relight/transport/face_points.h"
#include "relight/transport/patch_scene.h"
#include "scene/sky_shape.h"

namespace pleinair {

inline constexpr int kAllBounces = -1;

// A point on a surface that gathers light over the hemisphere around its normal.
struct Receiver {
  glm::vec3 position_m{0.0f};
  glm::vec3 normal{0.0f, 0.0f, 1.0f};  // Unit, to the side that gathers.
};

struct GatherOptions {
  // Cosine-distributed, low-discrepancy. Converged: as many as wished, up to 65536.
  int rays_per_receiver = 256;
  std::uint64_t seed = 1;
  // Faces alone: rays start from where light can reach, see FacePoints; faces that it can't reach
  // see nothing and stay dark. Only for light that comes from sky and sun. Rays are rounded up to a
  // multiple of FacePoints::kCells.
  bool from_exposed_parts = false;
  // So many receivers in a row, of one normal, cast parts of one set of directions; 1 to 1024.
  // Together they sample what they all see as evenly as one receiver with all their rays.
  int receivers_per_set = 1;
  // The number of the first receiver, where they are part of a longer list: each then casts the
  // rays that it would cast among all. A multiple of receivers_per_set.
  std::size_t first_receiver = 0;
  // For rays that meet this face or a later one, and for those that end in the dark below the
  // horizon, the directions are kept too: see OtherDirectionsOf.
  std::size_t keep_directions_from_face = std::numeric_limits<std::size_t>::max();
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// What receivers see: per receiver the faces hit, and the directions that reach the sky. A ray that
// meets nothing and does not rise above the horizon is dark. The result does not depend on the
// number of threads; receiver i's rays depend on the seed, i and the receiver alone.
class GatheredRays {
 public:
  GatheredRays() = default;
  // A receiver without a unit normal sees nothing.
  GatheredRays(const PatchScene& scene,
               std::span<const Receiver> receivers,
               const GatherOptions& options);
  // Receiver i casts the rays that receiver identities[i] of a longer list would.
  GatheredRays(const PatchScene& scene,
               std::span<const Receiver> receivers,
               std::span<const std::uint32_t> identities,
               const GatherOptions& options);
  // Rays in two scenes in one place: the faces of `first`, then those of `second`. Skylines are
  // left out.
  GatheredRays(const PatchScene& first,
               const PatchScene& second,
               std::span<const Receiver> receivers,
               const GatherOptions& options);
  // One receiver a face, its rays starting all over the patch: face-to-face form factors.
  static GatheredRays OfFaces(const PatchScene& scene, const GatherOptions& options);
  // The same from the exposed parts of faces, whatever options.from_exposed_parts says; returns
  // them in `points`.
  static GatheredRays OfExposedFaces(const PatchScene& scene,
                                     const GatherOptions& options,
                                     FacePoints& points);

  std::size_t ReceiverCount() const { return face_begin_.empty() ? 0 : face_begin_.size() - 1; }
  int RaysPerReceiver() const { return rays_per_receiver_; }
  // Irradiance at each receiver straight from the sky (c, for a uniform shape).
  std::vector<glm::vec3> FromSky(const SkyShape& shape) const;
  // The same for several shapes, with one pass over the rays.
  std::vector<std::vector<glm::vec3>> FromSkies(std::span<const SkyShape* const> shapes) const;
  // Irradiance at each receiver from faces of given radiosity.
  std::vector<glm::vec3> FromFaces(std::span<const glm::vec3> face_radiosity) const;
  // The same for many lights at once.
  // Shape  face_radiosity [face * lights + light], the result [receiver * lights + light].
  std::vector<glm::vec3> FromFaces(std::span<const glm::vec3> face_radiosity,
                                   std::size_t lights) const;
  // The same for one light and one receiver, unchecked: for inner loops.
  glm::vec3 FromFacesAt(std::size_t receiver, std::span<const glm::vec3> face_radiosity) const;

  // The share of a receiver's rays that meet each face (an estimate of its form factors), and that
  // reach the sky.
  struct FaceShare {
    std::int32_t face;
    float share;
  };
  std::vector<FaceShare> FacesOf(std::size_t receiver) const;
  std::vector<glm::vec3> SkyDirectionsOf(std::size_t receiver) const;
  // Where they were asked for: GatherOptions::keep_directions_from_face. To 0.1 deg.
  std::vector<glm::vec3> OtherDirectionsOf(std::size_t receiver) const;

  // Defined in relight/internal/serialization.h.
  template <class Archive>
  void serialize(Archive& archive);

 private:
  // Per receiver i the entries [face_begin_[i], face_begin_[i + 1]): each face once, ascending,
  // with its share of rays.
  std::vector<std::uint64_t> face_begin_;
  std::vector<std::int32_t> face_;
  std::vector<float> face_share_;
  // Per receiver the directions that reach the sky, packed to 32 bits (0.003 deg); each carries
  // 1 / rays_per_receiver.
  std::vector<std::uint64_t> sky_begin_;
  std::vector<std::uint32_t> sky_direction_;
  // Derived from these: the cell of SkyTable that each lies in, and per receiver the sum of their
  // heights (z).
  std::vector<std::uint16_t> sky_cell_;
  std::vector<double> sky_heights_;
  std::int32_t rays_per_receiver_ = 1;
  // Where the scene has a skyline: the light that it hides from each receiver, mesh apart, over the
  // estimate of that by the receiver's rays. Without this factor the rays' scatter would look like
  // varying light on level ground, where light is uniform.
  std::vector<float> hidden_scale_;
  // Per receiver, other directions that are kept, packed to 32 bits; else empty.
  std::vector<std::uint64_t> other_begin_;
  std::vector<std::uint32_t> other_direction_;
  // Rays of each receiver where they differ; else empty.
  std::vector<std::int32_t> ray_count_;

  friend class PatchTransport;
  std::int32_t RayCountOf(std::size_t receiver) const {
    return ray_count_.empty() ? rays_per_receiver_ : ray_count_[receiver];
  }

  void DescribeSky();
  template <class RayStarts, class Scenes>
  void Gather(const Skyline& skyline,
              std::size_t receiver_count,
              const GatherOptions& options,
              const RayStarts& ray_start,
              const Scenes& scenes);
};

// Radiosity (W m^-2 per unit of irradiance) of every face for one unit basis light.
struct FaceLight {
  std::vector<glm::vec3> radiosity;
  int iterations = 0;
  // Largest change in the last iteration, relative to the largest radiosity. 0 where the asked-for
  // bounces are finite.
  double residual = 0.0;
  // Irradiance of every face straight from the light, where SolveSun made it; else empty.
  std::vector<glm::vec3> direct_irradiance{};
};

// The same for many basis lights at once.
struct FaceLights {
  std::size_t lights = 0;
  std::vector<glm::vec3> radiosity;  // [face * lights + light].
  int iterations = 0;                // The most that a block of lights took.
  double residual = 0.0;             // The largest of any light, relative to that light.
  // |arrived - sent| / sent of the light that faces send to each other, the worst of all lights.
  // Light that arrives by the receivers' rays should equal light that leaves by the senders'; they
  // differ by the rays' noise and the patches' size. 0 where no light is sent.
  double energy_error = 0.0;

  std::size_t FaceCount() const { return lights == 0 ? 0 : radiosity.size() / lights; }
  std::vector<glm::vec3> OfLight(std::size_t light) const;
};

struct SolveOptions {
  // Reflections on the way to a receiver: 0 leaves every face dark, 1 has faces reflect direct
  // light only, kAllBounces iterates to convergence.
  int bounces = kAllBounces;
  // All bounces: what may be missing of each light, as a share of its largest radiosity.
  double tolerance = 1e-6;
  Progress progress{};  // May be empty.
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Peak memory of the transport between `patches` patches under `lights` lights: rays, sky
// visibility of `sky_directions` directions, direct light and radiosities. An upper bound.
std::size_t RadiosityBytes(std::size_t patches,
                           std::size_t lights,
                           const GatherOptions& options,
                           std::size_t sky_directions);

// Share of the sun's disc that is seen from a point, 0..1, from up to `samples` rays spread over
// the disc; see SunDisc in sun_disc.h for where fewer are cast. What is below the horizon
// is not seen.
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
  // reflect direct light only. kAllBounces iterates until what is missing is below 1e-6 of the
  // largest radiosity. Throws std::invalid_argument when the scene is not the one of construction
  // (by face count), or bounces < -1.
  FaceLight SolveSun(const PatchScene& scene,
                     const glm::dvec3& sun_direction_enu,
                     double sun_angular_radius_rad,
                     int bounces) const;

  // Several at once, with one pass over the form factors: the same lights in less time. The skies
  // in their order, then the sun where there is one.
  struct Sun {
    glm::dvec3 direction_enu{0.0, 0.0, 1.0};
    double angular_radius_rad = 0.0;
  };
  std::vector<FaceLight> SolveTogether(const PatchScene& scene,
                                       std::span<const std::shared_ptr<const SkyShape>> skies,
                                       const std::optional<Sun>& sun,
                                       int bounces) const;

  // The parts of the above, for callers that change albedos and keep the light.
  std::vector<glm::vec3> DirectFromSky(const SkyShape& shape) const {
    return face_rays_.FromSky(shape);
  }
  std::vector<glm::vec3> DirectFromSun(const PatchScene& scene,
                                       const glm::dvec3& sun_direction_enu,
                                       double sun_angular_radius_rad) const;
  // Also for faces that shine by themselves: `direct_irradiance` is then emission / albedo.
  FaceLight Solve(const PatchScene& scene,
                  std::span<const glm::vec3> direct_irradiance,
                  int bounces) const;

  // All lights in one pass over the form factors: [face * lights + light]. Solve is its case of
  // one light. Throws std::invalid_argument as Solve.
  FaceLights SolveMany(const PatchScene& scene,
                       std::span<const glm::vec3> direct_irradiance,
                       std::size_t lights,
                       const SolveOptions& options) const;

  const GatheredRays& FaceRays() const { return face_rays_; }
  // Empty unless made with from_exposed_parts.
  const FacePoints& Points() const { return face_points_; }

  // Defined in relight/internal/serialization.h.
  template <class Archive>
  void serialize(Archive& archive);

 private:
  FaceLights SolveBlocks(const PatchScene& scene,
                         std::span<const glm::vec3> direct_irradiance,
                         std::size_t lights,
                         const SolveOptions& options) const;
  double EnergyError(const PatchScene& scene, const FaceLights& solved) const;

  // Before face_rays_, whose making fills it.
  FacePoints face_points_;
  GatheredRays face_rays_;
};

}  // namespace pleinair
