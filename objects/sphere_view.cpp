#include "objects/sphere_view.h"

#include <numbers>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>

#include "scene/sphere_directions.h"

namespace pleinair {

SphereView::SphereView(const PatchScene& scene,
                       std::span<const glm::vec3> places_m,
                       int directions,
                       std::uint64_t seed)
    : faces_(scene.FaceCount()) {
  if (directions < 1) {
    throw std::invalid_argument("sphere view: directions is " + std::to_string(directions) +
                                ": expected at least 1");
  }
  directions_ = internal::SphereDirections(directions + directions % 2, seed);
  sources_.resize(places_m.size() * directions_.size());
  tbb::parallel_for(std::size_t{0}, sources_.size(), [&](std::size_t i) {
    const glm::vec3& direction = directions_[i % directions_.size()];
    const auto hit = scene.caster.Intersect(places_m[i / directions_.size()], direction);
    const std::int32_t open = direction.z > 0.0f ? PatchScene::kSky : kDark;
    sources_[i] = hit ? scene.FaceOfHit(*hit, direction) : open;
  });
}

std::vector<glm::vec3> SphereView::Radiance(std::size_t place,
                                            const SkyShape* sky,
                                            std::span<const glm::vec3> face_radiosity) const {
  if (face_radiosity.size() != faces_) {
    throw std::invalid_argument("sphere view: radiosity of " +
                                std::to_string(face_radiosity.size()) + " faces, expected " +
                                std::to_string(faces_));
  }
  if (place >= PlaceCount()) {
    throw std::invalid_argument("sphere view: place " + std::to_string(place) + " of " +
                                std::to_string(PlaceCount()));
  }
  std::vector<glm::vec3> radiance(directions_.size(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const std::int32_t source = sources_[place * directions_.size() + i];
    if (source >= 0) {
      radiance[i] =
          std::numbers::inv_pi_v<float> * face_radiosity[static_cast<std::size_t>(source)];
    } else if (source == PatchScene::kSky && sky != nullptr) {
      radiance[i] = sky->Radiance(directions_[i]);
    }
  }
  return radiance;
}

}  // namespace pleinair
