// Fixed functions of direction whose mix is a sky's light.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Per cell of SkyTable.
struct PartlyHiddenTables {
  std::vector<glm::vec3> bare;
  // The change by the hiding, with the mean of the reflected light: for an even sky the same in
  // each cell, times the share that is hidden.
  std::vector<glm::vec3> change;
};

// Radiance over the upper hemisphere, scaled per channel so that an unoccluded horizontal plane
// gets irradiance 1. Immutable, safe from any thread.
class SkyShape {
 public:
  virtual ~SkyShape() = default;
  virtual std::string Name() const = 0;  // As in lighting.jsonl's sky_shape.
  // Zero on and below the horizon. `direction_enu` is unit.
  virtual glm::vec3 Radiance(const glm::vec3& direction_enu) const = 0;
  // Where above the horizon it is `level + rise * direction.z`, the same in all channels; else
  // none.
  struct ByHeight {
    double level = 0.0;
    double rise = 0.0;
  };
  virtual std::optional<ByHeight> LinearInHeight() const { return std::nullopt; }
  // For callers that know the cells of many directions: radiance of each of SkyTable's cells, where
  // Radiance is a look-up of that; else null.
  virtual const std::vector<glm::vec3>* Table() const { return nullptr; }
  // For a sky that is partly hidden: the shape separate from what hides it; else null.
  virtual const PartlyHiddenTables* PartlyHidden() const { return nullptr; }
};

// The sky of equal radiance in all directions: "uniform".
std::shared_ptr<const SkyShape> MakeUniformSkyShape();

// A sky by a table over the hemisphere's equal-area map to a disc: a look-up costs a square root.
// Directions within one cell, 0.45 deg across, have the same radiance.
class SkyTable {
 public:
  static constexpr int kSide = 256;
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;

  // Cells whose centre lies outside the disc count as the horizon next to them.
  static glm::dvec3 DirectionOfCell(std::size_t cell);
  // Solid angle of a cell in an integral; 0 outside the disc.
  static double SolidAngleSr(std::size_t cell);
  // The cell of a unit direction above the horizon.
  static std::size_t CellOf(const glm::vec3& direction_enu);
};

// The shape whose radiance in each of SkyTable's cells is `radiance`, relative. A channel that is
// black everywhere stays without light.
// Throws std::invalid_argument for another length than kCells, a value below 0 or not finite.
std::shared_ptr<const SkyShape> MakeTableSkyShape(std::string name,
                                                  std::vector<glm::vec3> radiance);
// Irradiance of such a table on an unoccluded horizontal plane.
glm::dvec3 HorizontalIrradiance(std::span<const glm::vec3> table);

// The shape of a lat-long sky image (any size, without the disc), interpolated between its pixels'
// centres. Pixels below the horizon are ignored. A channel that is black over the entire sky has no
// light.
//
// Throws  std::invalid_argument for an image with defects, or with less than two rows.
std::shared_ptr<const SkyShape> MakeImageSkyShape(std::string name, const RgbImage& sky_radiance);

// Irradiance of a lat-long sky image on an unoccluded horizontal plane: the scale that
// MakeImageSkyShape divides by.
glm::dvec3 HorizontalIrradiance(const RgbImage& sky_radiance);

}  // namespace pleinair
