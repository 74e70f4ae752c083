// The view of places in the open in all directions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "scene/sky_shape.h"

namespace pleinair {

// Rays are cast once; any basis light's radiance along them is then looked up. All places share one
// set of directions with the same errors, so that two places that see the same get the same light
// bit for bit.
//
// Threads  The result does not depend on their number.
class SphereView {
 public:
  SphereView() = default;
  // `directions` are spread evenly over the sphere (see internal::SphereDirections), rounded up to
  // even. Keeps neither `scene` nor `places_m`. Throws std::invalid_argument for less than one.
  SphereView(const PatchScene& scene,
             std::span<const glm::vec3> places_m,
             int directions,
             std::uint64_t seed);

  std::size_t PlaceCount() const {
    return directions_.empty() ? 0 : sources_.size() / directions_.size();
  }
  // Unit; each stands for 4 pi / their number steradians.
  const std::vector<glm::vec3>& Directions() const { return directions_; }

  // The radiance at `place` from each direction: the sky's (null: none), or that of a face with the
  // given radiosity. Directions with neither, below the horizon, are dark.
  // Throws std::invalid_argument for another number of faces than the scene's, or no such place.
  std::vector<glm::vec3> Radiance(std::size_t place,
                                  const SkyShape* sky,
                                  std::span<const glm::vec3> face_radiosity) const;

 private:
  static constexpr std::int32_t kDark = -2;

  std::size_t faces_ = 0;
  std::vector<glm::vec3> directions_;
  std::vector<std::int32_t> sources_;  // [place * directions + direction]: a face, kSky or kDark.
};

}  // namespace pleinair
