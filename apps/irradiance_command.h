// `pleinair irradiance`: irradiance at given points and normals, to compare with other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "relight/point_irradiance.h"

namespace pleinair {

struct IrradianceCommandOptions {
  // Either a mesh under a light of unit strength ...
  std::filesystem::path scene;
  // At most one of these; none: the regions' default, 4x16.
  std::string sky_regions;  // "BANDSxSECTORS".
  bool uniform_sky = false;
  std::string sun;  // "AZ,EL" in degrees, azimuth from north clockwise.
  // ... or one frame's own light.
  std::filesystem::path sequence;
  int frame = 0;

  std::filesystem::path points;
  std::filesystem::path out;
  LightPart light = LightPart::kTotal;
  bool spherical_harmonics = false;
  PointIrradianceOptions gather;  // Its regions are set by sky_regions.
  std::filesystem::path cache;    // For prepared data and radiosities; empty: the user's.
};

// Writes `out`, completely or not at all. Throws std::runtime_error or std::invalid_argument, one
// line.
void RunIrradianceCommand(const IrradianceCommandOptions& options);

}  // namespace pleinair
