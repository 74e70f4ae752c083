// The basis lights of the present frame, and which of them are not those of the last.
#pragma once

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
  // Takes over what `builder`, which outlives this, was last updated for. `sun` is what the sun's
  // part is made for, without an intensity.
  void Update(SurfaceViewBuilder& builder,
              std::span<const std::shared_ptr<const SkyShape>> shapes,
              const DirectionalLight& sun);
  // All lights count as new.
  void Forget();

  std::size_t LightCount() const { return versions_.size(); }
  // Changes when the light does; no two lights share one.
  std::uint64_t Version(std::size_t light) const { return versions_[light]; }
  const DirectionalLight& Sun() const { return sun_; }
  std::span<const std::shared_ptr<const SkyShape>> Shapes() const { return shapes_; }
  // Null for the sun.
  const SkyShape* Sky(std::size_t light) const {
    return light == 0 ? nullptr : shapes_[light - 1].get();
  }
  // Per unit of the light.
  const std::vector<glm::vec3>& FaceRadiosity(std::size_t light) const;
  // Of the sun.
  const std::vector<glm::vec3>& DirectIrradiance() const;
  const Survey* SurveyUnderCurrentSun() const { return builder_->SurveyUnderCurrentSun(); }

  // Irradiance that a surface which saw nothing but the brightest there is would get from a unit of
  // the light, the sun's disc and what stands close to an object left out.
  const glm::vec3& LargestIrradiance(std::size_t light) const { return largest_[light]; }

 private:
  SurfaceViewBuilder* builder_ = nullptr;
  DirectionalLight sun_;
  std::uint64_t sun_faces_version_ = 0;
  std::uint64_t last_version_ = 0;
  std::vector<std::shared_ptr<const SkyShape>> shapes_;
  std::vector<std::uint64_t> versions_;
  std::vector<glm::vec3> largest_;
};

// Intensity of a basis light.
glm::vec3 IntensityOf(const Lighting& lighting, std::size_t light);
// One unit of basis light `light` of `count`, for the sun's and the skies' intensities alone.
Lighting UnitOf(std::size_t light, std::size_t count);

// Which lights are worked out anew.
enum class Upto {
  kLacking,  // Those that never were: of the others what was made for an older sun will do.
  kCurrent,  // All that are not of the present sun and sky.
};

// Of which versions of the basis lights something has been worked out.
class LightsDone {
 public:
  void Forget() { versions_.clear(); }
  bool Ever(std::size_t light) const { return light < versions_.size() && versions_[light] != 0; }
  bool IsCurrent(const FrameBasis& basis, std::size_t light) const {
    return light < versions_.size() && versions_[light] == basis.Version(light);
  }
  void Done(const FrameBasis& basis, std::size_t light) {
    versions_.resize(basis.LightCount(), 0);
    versions_[light] = basis.Version(light);
  }
  // Of something else, which it was made from: it is no more current than that.
  void DoneAs(const LightsDone& source, std::size_t light) {
    versions_.resize(source.versions_.size(), 0);
    versions_[light] = source.versions_[light];
  }
  // Lights that shine in `lighting` and are not current.
  std::vector<std::size_t> StaleIn(const FrameBasis& basis,
                                   const Lighting& lighting,
                                   Upto upto = Upto::kCurrent) const;

 private:
  std::vector<std::uint64_t> versions_;
};

}  // namespace pleinair
