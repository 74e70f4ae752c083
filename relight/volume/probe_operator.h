// What each probe of a grid sees: environment pixels, faces, open sky (jensen-2006, section 3.3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "scene/sky_shape.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {

// counts probes along x, y, z; probe (i, j, k) stands at lower_m + spacing_m * (i, j, k).
// Index order: x fastest.
struct ProbeGrid {
  glm::vec3 lower_m{0.0f};
  glm::vec3 spacing_m{1.0f};
  glm::ivec3 counts{1};
  std::size_t ProbeCount() const {
    return static_cast<std::size_t>(counts.x) * static_cast<std::size_t>(counts.y) *
           static_cast<std::size_t>(counts.z);
  }
  glm::vec3 PositionM(std::size_t probe) const;
  // Throws std::invalid_argument naming the field: a count below 1, a position or spacing that is
  // not finite, a spacing that is not positive.
  void Validate() const;
};

// A grid of `counts` probes over a box, the outermost ones on its sides. Where there is one probe
// along an axis it stands in the middle; an axis along which the box is flat gets one.
// Throws std::invalid_argument for a count below 1 or a box that is not finite or turned inside
// out.
ProbeGrid MakeProbeGrid(const BoundingBox& box, glm::ivec3 counts);

struct ProbeOptions {
  int rays_per_probe = 1024;  // Over the entire sphere, low-discrepancy; rounded up to even.
  std::uint64_t seed = 1;
  // Throws std::invalid_argument unless 1 <= rays_per_probe <= 2^24.
  void Validate() const;
};

// A linear operator from (environment pixels, face radiosities, sky radiance) to SH coefficients of
// incident radiance. A ray that meets a surface takes the survey map's pixel where the map sees
// that very point, else the face. A ray to the sky takes the map's pixel of its direction where the
// map shows sky there, else the direction itself.
//
// All probes share one set of directions: its errors are the same at neighbours, so that nothing
// flickers or ripples as an object moves between them. A stored ray is the index of what it sees,
// nothing else (4 bytes; 2 MB for 8^3 probes of 1024 rays).
//
// Accuracy   of the quadrature alone: 1024 rays beside a house give the coefficients of 2^18 rays
//            to 0.6 % of their rms. A bright spot smaller than the rays' spacing (6 deg) may be
//            missed.
// Threads    immutable once made; construction and Apply spread over threads without a change of
//            any bit.
class ProbeOperator {
 public:
  ProbeOperator() = default;
  // `survey` may be null: then nothing is taken from a map. Keeps neither scene nor survey.
  // Throws std::invalid_argument for a grid or options that make no sense, or a survey whose images
  // have the wrong size.
  ProbeOperator(const PatchScene& scene,
                const Survey* survey,
                const ProbeGrid& grid,
                const ProbeOptions& options);

  const ProbeGrid& Grid() const { return grid_; }
  // A probe that sees mostly the inside of surfaces stands in a wall and is not to be used; its
  // coefficients are 0. One that lies on a surface is moved slightly, to the side that sees more
  // sky.
  const std::vector<std::uint8_t>& Valid() const { return valid_; }

  // SH coefficients a probe. `environment` is lat-long of the survey map's size (empty without a
  // survey); radiance of faces is radiosity / pi; sky_radiance answers for directions not in the
  // map. An empty span is black.
  // Cost    a multiplication of 27 numbers a ray: some ms for 8^3 probes of 1024 rays.
  // Throws  std::invalid_argument for a span that is neither empty nor as long as it must be.
  std::vector<ShRgb> Apply(std::span<const glm::vec3> environment,
                           std::span<const glm::vec3> face_radiosity,
                           std::span<const glm::vec3> sky_radiance_of_directions) const;

  // The directions that Apply's last argument is for, in its order: the upper half of the rays'.
  const std::vector<glm::vec3>& SkyDirections() const { return sky_directions_; }

  // Supports cereal's binary and portable binary archives. Throws (cereal's exception, or one that
  // states what does not fit) for bytes that are no operator.
  template <class Archive>
  void serialize(Archive& archive);

 private:
  // Y of one direction times the solid angle that it stands for; three zeros round it up to whole
  // registers.
  using RayWeights = std::array<float, 12>;

  std::size_t RayCount() const { return ray_weights_.size(); }
  void MakeDirections(int rays_per_probe, std::uint64_t seed);

  ProbeGrid grid_;
  std::uint64_t seed_ = 1;
  std::uint32_t map_pixels_ = 0;
  std::uint32_t faces_ = 0;
  std::vector<std::uint8_t> valid_;
  // What ray r of probe p sees, at p * RayCount() + r: see internal::SourceLayout.
  std::vector<std::uint32_t> sources_;

  // These follow from the seed and the number of rays.
  std::vector<glm::vec3> directions_;
  std::vector<glm::vec3> sky_directions_;
  std::vector<RayWeights> ray_weights_;
};

}  // namespace pleinair
