#include "sunmodel/sky_shapes.h"

#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "sunmodel/sky_luminance.h"

namespace pleinair {
namespace {

class OvercastSkyShape final : public SkyShape {
 public:
  std::string Name() const override { return "overcast"; }
  glm::vec3 Radiance(const glm::vec3& direction_enu) const override {
    return glm::vec3(
        static_cast<float>(OvercastSkyLuminance(glm::dvec3(direction_enu)) / kIrradiance));
  }
  std::optional<ByHeight> LinearInHeight() const override {
    return ByHeight{1.0 / (3.0 * kIrradiance), 2.0 / (3.0 * kIrradiance)};
  }

 private:
  // The integral of (1 + 2 sin e) / 3 times sin e over the hemisphere.
  static constexpr double kIrradiance = 7.0 * std::numbers::pi / 9.0;
};

}  // namespace

std::shared_ptr<const SkyShape> MakeOvercastSkyShape() {
  return std::make_shared<OvercastSkyShape>();
}

std::shared_ptr<const SkyShape> MakeClearSkyShape(const glm::dvec3& sun_direction_enu,
                                                  double aerosol_optical_depth_500nm) {
  const ClearSkyDistribution sky(sun_direction_enu, aerosol_optical_depth_500nm);
  std::vector<glm::vec3> table(SkyTable::kCells);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, table.size(), 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t cell = range.begin(); cell < range.end(); ++cell) {
                        table[cell] = glm::vec3(sky.Radiance(SkyTable::DirectionOfCell(cell)));
                      }
                    });
  return MakeTableSkyShape("clear", std::move(table));
}

std::string_view NameOf(SkyShapeKind kind) {
  switch (kind) {
    case SkyShapeKind::kUniform:
      return "uniform";
    case SkyShapeKind::kOvercast:
      return "overcast";
    case SkyShapeKind::kClear:
      return "clear";
  }
  return "";
}

bool TurnsWithTheSun(SkyShapeKind kind) { return kind == SkyShapeKind::kClear; }

std::shared_ptr<const SkyShape> MakeSkyShape(SkyShapeKind kind,
                                             const glm::dvec3& sun_direction_enu,
                                             double aerosol_optical_depth_500nm) {
  switch (kind) {
    case SkyShapeKind::kUniform:
      return MakeUniformSkyShape();
    case SkyShapeKind::kOvercast:
      return MakeOvercastSkyShape();
    case SkyShapeKind::kClear:
      return MakeClearSkyShape(sun_direction_enu, aerosol_optical_depth_500nm);
  }
  throw std::invalid_argument("sky shape: no such kind");
}

}  // namespace pleinair
