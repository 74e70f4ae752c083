#include "scene/skyline.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

// Irradiance turns slowly with the normal: between these, 5.6 deg apart, it is linear to 0.2 %.
constexpr LatLongSize kNormals{64, 32};

class PartlyHiddenSkyShape final : public SkyShape {
 public:
  PartlyHiddenSkyShape(std::string name, std::vector<glm::vec3> table, PartlyHiddenTables tables)
      : name_(std::move(name)), table_(std::move(table)), tables_(std::move(tables)) {}
  std::string Name() const override { return name_; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    if (!(direction_enu.z > 0.0f)) return glm::vec3(0.0f);
    return table_[SkyTable::CellOf(direction_enu)];
  }
  const std::vector<glm::vec3>* Table() const override { return &table_; }
  const PartlyHiddenTables* PartlyHidden() const override { return &tables_; }

 private:
  std::string name_;
  std::vector<glm::vec3> table_;
  PartlyHiddenTables tables_;
};

RgbImage IrradianceOf(const std::vector<float>& hidden) {
  struct Source {
    glm::vec3 direction;
    float weight_sr;
  };
  std::vector<Source> sources;
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    if (!(hidden[cell] > 0.0f)) continue;
    sources.push_back({glm::vec3(SkyTable::DirectionOfCell(cell)),
                       static_cast<float>(hidden[cell] * SkyTable::SolidAngleSr(cell))});
  }
  RgbImage irradiance(kNormals.width, kNormals.height);
  for (int y = 0; y < kNormals.height; ++y) {
    for (int x = 0; x < kNormals.width; ++x) {
      const glm::vec3 normal(DirectionFromLatLong({x + 0.5, y + 0.5}, kNormals));
      float sum = 0.0f;
      for (const Source& source : sources) {
        sum += source.weight_sr * std::max(glm::dot(normal, source.direction), 0.0f);
      }
      irradiance.At(x, y) = glm::vec3(sum);
    }
  }
  return irradiance;
}

// Mean of what hides the sky, weighted as level ground sees it.
glm::vec3 MeanReflected(const Skyline& skyline) {
  glm::dvec3 sum(0.0);
  double hidden = 0.0;
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    const double weight = SkyTable::SolidAngleSr(cell) * SkyTable::DirectionOfCell(cell).z;
    sum += weight * glm::dvec3(skyline.reflected[cell]);
    hidden += weight * skyline.hidden[cell];
  }
  return hidden > 0.0 ? glm::vec3(sum / hidden) : glm::vec3(0.0f);
}

}  // namespace

Skyline MakeSkyline(std::vector<float> hidden, std::vector<glm::vec3> reflected) {
  if (hidden.size() != SkyTable::kCells || reflected.size() != SkyTable::kCells) {
    throw std::invalid_argument("skyline of " + std::to_string(hidden.size()) + " and " +
                                std::to_string(reflected.size()) + " cells: expected " +
                                std::to_string(SkyTable::kCells));
  }
  if (std::none_of(hidden.begin(), hidden.end(), [](float share) { return share > 0.0f; })) {
    return {};
  }
  RgbImage irradiance = IrradianceOf(hidden);
  return {std::move(hidden), std::move(reflected), std::move(irradiance)};
}

std::shared_ptr<const SkyShape> SeenPast(const Skyline& skyline,
                                         std::shared_ptr<const SkyShape> shape) {
  if (skyline.Empty()) return shape;
  const glm::vec3 mean_reflected = MeanReflected(skyline);
  const std::vector<glm::vec3>* const of_shape = shape->Table();
  std::vector<glm::vec3> table(SkyTable::kCells);
  PartlyHiddenTables tables{std::vector<glm::vec3>(SkyTable::kCells),
                            std::vector<glm::vec3>(SkyTable::kCells)};
  for (std::size_t cell = 0; cell < table.size(); ++cell) {
    tables.bare[cell] = of_shape != nullptr
                            ? (*of_shape)[cell]
                            : shape->Radiance(glm::vec3(SkyTable::DirectionOfCell(cell)));
    tables.change[cell] = skyline.hidden[cell] * (mean_reflected - tables.bare[cell]);
    table[cell] = (1.0f - skyline.hidden[cell]) * tables.bare[cell] + skyline.reflected[cell];
  }
  return std::make_shared<PartlyHiddenSkyShape>(shape->Name(), std::move(table), std::move(tables));
}

}  // namespace pleinair
