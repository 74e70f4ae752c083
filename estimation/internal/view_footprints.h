// Where footprints may lie in a view, and their model.
#pragma once

#include <cstddef>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "estimation/sample_selection.h"
#include "scene/camera.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair::estimation_internal {

// Pixels between a footprint and the nearest edge, for what pose and mesh are off by.
inline constexpr float kEdgeMarginPx = 1.5f;
inline constexpr int kFacings = 6;  // The nearest of the six axes.

// The pixel of a camera's picture in which a place lies.
std::optional<glm::ivec2> PixelAt(const glm::vec3& place_world_m,
                                  const Camera& camera,
                                  const Lens& lens);

class ViewFootprints {
 public:
  // Keeps the references. `takes_grazing`: also pixels at grazing sun.
  ViewFootprints(const SurfaceView& view,
                 const glm::dvec3& sun_direction_enu,
                 const RgbImage& radiance,
                 const Gray8Image& unusable,
                 bool takes_grazing);

  bool IsCandidate(std::size_t pixel);
  bool IsLit(std::size_t pixel) const;
  // Region times kFacings plus facing; the pixel has a region.
  int PlaneAt(std::size_t pixel) const;
  // Where the view shows the footprint's place; none where it does not.
  std::optional<std::size_t> PixelOf(const SampleFootprint& footprint, const Lens& lens) const;
  // The footprint around a candidate, without its plane and weight. None where it is not one plane
  // of one region, or holds an unusable pixel.
  std::optional<SampleFootprint> Gather(std::size_t centre);

  // Of all that was asked for.
  bool RefusedUnusablePixels() const { return refused_unusable_; }
  bool LeftOutGrazing() const { return left_out_grazing_; }

 private:
  // Pixels to each side of the centre.
  int RadiusAt(std::size_t pixel) const;
  JudgedSun JudgedAt(std::size_t pixel) const;
  float SunVisibilityAt(std::size_t pixel) const;

  const SurfaceView& view_;
  const glm::dvec3 sun_;
  const RgbImage& radiance_;
  const Gray8Image& unusable_;
  const bool takes_grazing_;
  bool refused_unusable_ = false;
  bool left_out_grazing_ = false;
};

}  // namespace pleinair::estimation_internal
