// The basis lights of the present frame, and which of them differ from the last frame's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/surface_view_builder.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

// Light 0 is the sun, 1 + k the sky's shape k.
class FrameBasis {
 public:
  // Takes over what `builder`, which outlives this, was last updated for. `sun` is the view's,
  // `bounce_sun` that of the light on faces (see SunPlace); both without an intensity.
  void Update(SurfaceViewBuilder& builder,
              const DirectionalLight& sun,
              const DirectionalLight& bounce_sun);

  std::size_t LightCount() const { return versions_.size(); }
  // Changes when the order or the number of lights changes: earlier results are then of none of
  // them.
  std::uint64_t Generation() const { return generation_; }
  // Whether some sky is new in this frame though the sun has not moved on: the next frame's may be.
  bool SkyIsNewAlone() const { return sky_is_new_alone_; }
  // Changes when the light does; no two lights share one.
  std::uint64_t Version(std::size_t light) const { return versions_[light]; }
  const DirectionalLight& Sun() const { return sun_; }
  // Where light 0 comes from: it changes with Version(0).
  const DirectionalLight& BounceSun() const { return bounce_sun_; }
  std::span<const std::shared_ptr<const SkyShape>> Shapes() const { return shapes_; }
  // Null for the sun.
  const SkyShape* Sky(std::size_t light) const {
    return light == 0 ? nullptr : shapes_[light - 1].get();
  }
  // Per unit of the light.
  const std::vector<glm::vec3>& FaceRadiosity(std::size_t light) const;
  // Direct irradiance of the sun on the faces.
  const std::vector<glm::vec3>& DirectIrradiance() const;
  const Survey* SurveyUnderCurrentSun() const { return builder_->SurveyUnderCurrentSun(); }

  // Irradiance from a unit of the light on a surface that saw the brightest radiance in all
  // directions. The sun's disc and surfaces close to an object are left out.
  const glm::vec3& LargestIrradiance(std::size_t light) const { return largest_[light]; }

 private:
  SurfaceViewBuilder* builder_ = nullptr;
  DirectionalLight sun_;
  DirectionalLight bounce_sun_;
  std::uint64_t sun_faces_version_ = 0;
  std::uint64_t last_version_ = 0;
  std::uint64_t generation_ = 0;
  bool sky_is_new_alone_ = false;
  std::vector<std::shared_ptr<const SkyShape>> shapes_;
  std::vector<std::uint64_t> versions_;
  std::vector<glm::vec3> largest_;
};

// Intensity of a basis light.
glm::vec3 IntensityOf(const Lighting& lighting, std::size_t light);
// One unit of basis light `light` of `count`, for the sun's and the skies' intensities alone.
Lighting UnitOf(std::size_t light, std::size_t count);

// Which lights are recomputed.
enum class Upto {
  kLacking,  // Those never computed; for others, results for an older sun or sky suffice.
  kCurrent,  // All that were not computed for the present sun and sky.
};

// The versions of the basis lights from which something has been computed.
class LightsDone {
 public:
  // Whether the light was computed, for this version or for an older sun or sky in its place.
  bool Ever(const FrameBasis& basis, std::size_t light) const {
    return light < made_.size() && made_[light].generation == basis.Generation() &&
           made_[light].version != 0;
  }
  bool IsCurrent(const FrameBasis& basis, std::size_t light) const {
    return light < made_.size() && made_[light].version == basis.Version(light);
  }
  void Done(const FrameBasis& basis, std::size_t light) {
    made_.resize(basis.LightCount());
    made_[light] = {
        basis.Version(light), basis.Generation(), basis.BounceSun().direction_enu, ++last_stamp_};
  }
  // All count as never computed from now on.
  void Lapse() {
    for (Made& made : made_) made.version = 0;
  }
  // Changes each time that the light is computed; 0 where it never was.
  std::uint64_t Stamp(std::size_t light) const {
    return light < made_.size() ? made_[light].stamp : 0;
  }
  // Lights that shine in `lighting` and are not current.
  std::vector<std::size_t> StaleIn(const FrameBasis& basis,
                                   const Lighting& lighting,
                                   Upto upto = Upto::kCurrent) const;
  // Radians by which the sun has moved since the oldest light that shines was computed.
  double SunGoneOnRad(const FrameBasis& basis, const Lighting& lighting) const;

 private:
  struct Made {
    std::uint64_t version = 0;
    std::uint64_t generation = 0;
    glm::dvec3 sun_direction_enu{0.0};
    std::uint64_t stamp = 0;
  };
  std::vector<Made> made_;  // One a light.
  std::uint64_t last_stamp_ = 0;
};

}  // namespace pleinair
