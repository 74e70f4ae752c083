// What each probe of a grid sees: environment pixels, faces, open sky (jensen-2006, section 3.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/patch_scene.h"
#include "relight/sky_shape.h"
#include "relight/survey.h"
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
};

// A grid of `counts` probes over a box, with a margin of half a spacing left out on no side.
ProbeGrid MakeProbeGrid(const BoundingBox& box, glm::ivec3 counts);

struct ProbeOptions {
  int rays_per_probe = 1024;  // Over the whole sphere, low-discrepancy.
  std::uint64_t seed = 1;
};

// A linear operator from (environment pixels, face radiosities, sky radiance) to SH coefficients of
// incident radiance. A ray that meets a surface which the survey map sees at that very point takes
// that pixel; else the face; a ray to the sky takes the map's pixel of that direction where the map
// shows sky there, else the direction itself.
class ProbeOperator {
 public:
  ProbeOperator() = default;
  // `survey` may be null: then nothing is taken from a map.
  ProbeOperator(const PatchScene& scene,
                const Survey* survey,
                const ProbeGrid& grid,
                const ProbeOptions& options);

  const ProbeGrid& Grid() const { return grid_; }
  // A probe that sees mostly the inside of surfaces stands in a wall and is not to be used.
  const std::vector<std::uint8_t>& Valid() const { return valid_; }

  // SH coefficients a probe. `environment` is lat-long of the survey map's size (empty without a
  // survey); radiance of faces is radiosity / pi; sky_radiance answers for directions not in the
  // map.
  std::vector<ShRgb> Apply(std::span<const glm::vec3> environment,
                           std::span<const glm::vec3> face_radiosity,
                           std::span<const glm::vec3> sky_radiance_of_directions) const;

  // The directions that Apply's last argument is for, in its order.
  const std::vector<glm::vec3>& SkyDirections() const { return sky_directions_; }

  template <class Archive>
  void serialize(Archive& archive);

 private:
  ProbeGrid grid_;
  std::vector<std::uint8_t> valid_;
  std::vector<glm::vec3> sky_directions_;
  // The stored rays are the source's matter.
  struct Entry {
    std::uint32_t index;
    std::array<float, kProbeShCoefficients> weight;
  };
  std::vector<std::uint32_t> pixel_begin_, face_begin_, sky_begin_;
  std::vector<Entry> pixels_, faces_, skies_;
};

}  // namespace pleinair
