// What of a frame decides its view: the sun that transport is made for, and where may be sampled.
#pragma once

#include <optional>
#include <vector>

#include "estimation/lighting_source.h"
#include "relight/surface_view_builder.h"
#include "scene/frame.h"
#include "sunmodel/site.h"

namespace pleinair {

struct TransportTime {
  UtcTime time{};
  SunState sun;
};

// The sun in the middle of the cell that the frame's time lies in, on a raster of `step_s` (0: at
// its very time), so that transport is a pure function of time and is kept while the sun has hardly
// moved. `sun` itself where the frame states its direction or there is no site.
TransportTime TransportSun(const std::optional<Site>& site,
                           const Frame& frame,
                           const SunState& sun,
                           double step_s);

std::vector<SampleRegionPolygon> SampleRegionsOf(const Frame& frame);

}  // namespace pleinair
