// The files of `pleinair irradiance`: points in, irradiance or coefficients out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/point_irradiance.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {

struct PointsFile {
  std::vector<glm::vec3> points_m;
  std::vector<glm::vec3> normals;  // Unit.
};

// Reads {"points": [[x, y, z], ...], "normals": [[x, y, z], ...]}; normals may be missing where
// they are not `needed`. Throws std::runtime_error naming file, key and what was expected: an
// unknown key, no point, coordinates that are not numbers or beyond 1e6 m, a normal that is not
// unit to 1e-3.
PointsFile ReadPointsFile(const std::filesystem::path& file, bool needs_normals);

// What the output states beside its numbers.
struct IrradianceHeading {
  std::string light_json;  // An object: which light, in what unit.
  LightPart part = LightPart::kTotal;
  int bounces = kAllBounces;
  RadiositySummary radiosity;
};

// The entire text of the output, with points and normals as they were read.
// Shape  irradiance [(point * normals + normal) * lights + light], coefficients
//        [point * lights + light].
std::string IrradianceText(const IrradianceHeading& heading,
                           const PointsFile& points,
                           std::span<const glm::vec3> irradiance,
                           std::size_t lights);
std::string CoefficientsText(const IrradianceHeading& heading,
                             const PointsFile& points,
                             std::span<const ShRgb> coefficients,
                             std::size_t lights);

}  // namespace pleinair
