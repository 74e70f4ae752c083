// The basis lights of the present frame, and which of them differ from the last frame's.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/surface_view_builder.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/state_id.h"

namespace pleinair {

// Light 0 is the sun, 1 + k the sky's shape k.
class FrameBasis {
 public:
  // Takes over what `builder`, which outlives this, was last updated for. `sun` is the view's,
  // `bounce_sun` that of the light on faces (see SunPlace); both without an intensity.
  void Update(SurfaceViewBuilder& builder,
              const DirectionalLight& sun,
              const DirectionalLight& bounce_sun);

  std::size_t LightCount() const { return light_ids_.size(); }
  // A new identity whenever the order or the number of lights changes: earlier results are then of
  // none of them.
  StateId OrderId() const { return order_id_; }
  // Whether some sky is new in this frame though the sun has not moved on: the next frame's may be.
  bool SkyIsNewAlone() const { return sky_is_new_alone_; }
  // A new identity whenever the light changes.
  StateId LightId(std::size_t light) const { return light_ids_[light]; }
  const DirectionalLight& Sun() const { return sun_; }
  // Where light 0 comes from: it changes with LightId(0).
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
  StateId sun_faces_id_;
  StateId order_id_ = StateId::Next();
  bool sky_is_new_alone_ = false;
  std::vector<std::shared_ptr<const SkyShape>> shapes_;
  std::vector<StateId> light_ids_;
  std::vector<glm::vec3> largest_;
};

// Intensity of a basis light.
glm::vec3 IntensityOf(const Lighting& lighting, std::size_t light);
// One unit of basis light `light` of `count`, for the sun's and the skies' intensities alone.
Lighting UnitOf(std::size_t light, std::size_t count);

// Which lights are recomputed.
enum class Refresh {
  kMissing,  // Those never computed; for others, results for an older sun or sky suffice.
  kStale,    // All that were not computed for the present sun and sky.
};

// The states of the basis lights from which something has been computed.
class LightsDone {
 public:
  // Whether the light was computed, in this state or for an older sun or sky in its place.
  bool Ever(const FrameBasis& basis, std::size_t light) const {
    return light < made_.size() && made_[light].order == basis.OrderId() &&
           made_[light].light.IsSet();
  }
  bool IsCurrent(const FrameBasis& basis, std::size_t light) const {
    return light < made_.size() && made_[light].light == basis.LightId(light);
  }
  void Done(const FrameBasis& basis, std::size_t light) {
    made_.resize(basis.LightCount());
    made_[light] = {
        basis.LightId(light), basis.OrderId(), basis.BounceSun().direction_enu, StateId::Next()};
  }
  // All count as never computed from now on, so that they are computed again.
  void Invalidate() {
    for (Made& made : made_) made.light = {};
  }
  // The identity of the last result, which stays in use after Invalidate; not set before the first.
  StateId ResultId(std::size_t light) const {
    return light < made_.size() ? made_[light].result : StateId();
  }
  // Lights that shine in `lighting` and are not current.
  std::vector<std::size_t> StaleIn(const FrameBasis& basis,
                                   const Lighting& lighting,
                                   Refresh refresh = Refresh::kStale) const;
  // Radians by which the sun has moved since the oldest light that shines was computed.
  double SunMotionRad(const FrameBasis& basis, const Lighting& lighting) const;

 private:
  struct Made {
    StateId light;
    StateId order;
    glm::dvec3 sun_direction_enu{0.0};
    StateId result;
  };
  std::vector<Made> made_;  // One a light.
};

}  // namespace pleinair
