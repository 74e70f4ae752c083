// What of a frame decides its view: the sun that transport is made for, and where may be sampled.
#pragma once

#include <optional>
#include <vector>

#include "estimation/lighting_source.h"
#include "relight/surface_view_builder.h"
#include "scene/frame.h"
#include "sunmodel/site.h"

namespace pleinair {

// On rasters of time; 0: at a frame's very time.
struct TransportSteps {
  double sun_s = 0.0;
  double bounces_s = 0.0;
};

struct TransportTime {
  UtcTime time{};
  SunState sun;
  SunState bounces;  // The sun for what its light does after it has met a surface.

  // The disc grows and shrinks by a ten thousandth a day: one of the two sizes serves both.
  SunPlace Place() const {
    return {sun.direction_enu, bounces.angular_radius_rad, bounces.direction_enu};
  }
};

// The sun in the middle of the cell that the frame's time lies in, so that transport is a pure
// function of time and is kept while the sun has hardly moved. `sun` itself where the frame states
// its direction or there is no site.
TransportTime TransportSun(const std::optional<Site>& site,
                           const Frame& frame,
                           const SunState& sun,
                           const TransportSteps& steps);

std::vector<SampleRegionPolygon> SampleRegionsOf(const Frame& frame);

}  // namespace pleinair
