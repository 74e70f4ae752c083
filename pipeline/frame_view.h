// What a frame's view depends on: the sun that transport is for, and the regions that may be
// sampled.
#pragma once

#include <optional>
#include <vector>

#include "estimation/lighting_source.h"
#include "relight/surface_view_builder.h"
#include "scene/frame.h"
#include "sunmodel/site.h"

namespace pleinair {

// Steps of the rasters of time; 0: each frame's own time.
struct TransportSteps {
  double sun_s = 0.0;
  double bounces_s = 0.0;
};

// The time and the suns that a frame's transport is computed for.
struct TransportTime {
  UtcTime time{};
  SunState sun;
  SunState bounces;  // The sun of its bounces: light after the first surface.

  // The disc changes by a ten thousandth a day: one of the two sizes is used for both.
  SunPlace Place() const {
    return {sun.direction_enu, bounces.angular_radius_rad, bounces.direction_enu};
  }
};

// Returns the sun in the middle of the raster's cell that contains the frame's time. So transport
// is a pure function of time, and is kept while the sun has hardly moved. Returns `sun` itself
// where the frame states its direction or there is no site.
TransportTime TransportSun(const std::optional<Site>& site,
                           const Frame& frame,
                           const SunState& sun,
                           const TransportSteps& steps);

// Returns the frame's sample polygons as regions of the view.
std::vector<SampleRegionPolygon> SampleRegionsOf(const Frame& frame);

}  // namespace pleinair
