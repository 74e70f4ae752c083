// Sunlight on the real surfaces close to virtual objects, as points on the objects see it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"
#include "scene/lighting.h"

namespace pleinair {

struct NearSunlightOptions {
  int rays_per_receiver = 32;  // Cosine-distributed. Converged: many.
  std::uint64_t seed = 1;
  // How far from the objects' common bounding sphere a surface is still near, as a multiple of that
  // sphere's radius: farther off a patch's mean is as good. Converged: many.
  double reach = 2.0;
  // The number of the first receiver, where they are part of a longer list: see GatherOptions.
  std::size_t first_receiver = 0;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Patches have one radiosity each, of a scene without the objects. Beside an object the error of
// this is visible: its foot stands in its own shadow, and the edge of a shadow nearby is smeared
// over a patch. Here the sun's visibility is tested at each place that a receiver's rays meet, past
// the objects too, in place of the patch's mean. One reflection: light from such places to other
// real surfaces is not changed.
//
// Threads  The result does not depend on their number.
class NearSunlight {
 public:
  NearSunlight() = default;
  // `objects` hide real surfaces from the receivers. Keeps no reference.
  NearSunlight(const PatchScene& real,
               const PatchScene& objects,
               std::span<const Receiver> receivers,
               const NearSunlightOptions& options = {});

  // Adds the receivers of another one that was made with the same options except first_receiver.
  void Append(const NearSunlight& next);

  std::size_t ReceiverCount() const { return first_place_.empty() ? 0 : first_place_.size() - 1; }

  // Correction to add to each receiver's irradiance under a unit of sun, without the disc's direct
  // light on the receiver. `real_direct` is the direct irradiance from that sun that the faces of
  // `real` were assumed to have. Throws std::invalid_argument for another number of faces.
  std::vector<glm::vec3> Change(const PatchScene& real,
                                const PatchScene& objects,
                                const DirectionalLight& sun,
                                std::span<const glm::vec3> real_direct) const;

 private:
  struct Place {
    glm::vec3 start_m{0.0f};  // Off the surface, to the face's side.
    std::int32_t face = 0;
  };
  struct RaysFromOnePlace;

  std::vector<std::uint32_t> first_place_;  // Per receiver, places [begin, next begin).
  std::vector<Place> places_;
  float share_ = 0.0f;  // A ray's share of a receiver's hemisphere.
};

}  // namespace pleinair
