// Sun and sky from the diffuse walls and paving that the camera sees (jensen-2006, section 3.1).
#pragma once

#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "estimation/lighting_fit_options.h"
#include "estimation/lighting_source.h"
#include "estimation/sample_selection.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {

// Set-up of the source.
struct OutdoorLightingOptions {
  int samples = 500;  // At most; fewer where the view has fewer. 1 .. 100000.
  std::uint64_t seed = 1;
  SampleChoice choice = SampleChoice::kBalanced;
  LightingFitOptions fit{};
  // The shapes whose mix is the sky: at least one, each at most once. Uniform alone is
  // jensen-2006's model.
  std::vector<SkyShapeKind> sky_shapes{std::begin(kAllSkyShapeKinds), std::end(kAllSkyShapeKinds)};
  // Haze of a clear sky, as measured by the survey (see SurveyLight). 0 .. 5.
  double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// Makes the source. Throws std::invalid_argument as OutdoorLightingOptions::Validate.
std::unique_ptr<LightingSource> MakeOutdoorLightingSource(const OutdoorLightingOptions& options);

}  // namespace pleinair
