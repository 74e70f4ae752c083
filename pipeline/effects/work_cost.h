// What pieces of work cost, as the plan is told.
#pragma once

#include "objects/vertex_light.h"

namespace pleinair {

// What a piece of work will cost.
struct WorkCost {
  double expected_ms = 0.0;  // As learned here.
  double nominal_ms = 0.0;   // The same everywhere.
  bool is_kept = false;
  // Of expected_ms, what later frames need not do again where nothing moves, and what they need not
  // before the sun has moved on.
  double once_ms = 0.0;
  double sun_ms = 0.0;
};

// Of light that is worked out once and again as the sun moves: what was never made, and what was
// made for an older sun.
struct LightCost {
  WorkCost lacking;
  WorkCost now;

  bool HasOlder() const { return now.nominal_ms > 0.0; }
  double NominalMs() const { return lacking.nominal_ms + now.nominal_ms; }
};

// Costs of light on the objects, by the ways of computing it.
struct LightCosts {
  LightCost at_vertices;
  LightCost at_single_probe;
  LightCost without_objects;  // At a single probe, without what objects hide and reflect.
  WorkCost between;  // What objects hide and reflect at vertices, where it is a separate work.
  bool between_is_apart = false;

  bool AnyHasOlder() const {
    return at_vertices.HasOlder() || at_single_probe.HasOlder() || without_objects.HasOlder();
  }
  const LightCost& Of(const VertexLight::Mode& mode) const {
    if (mode.at == VertexLight::At::kVertices) return at_vertices;
    return mode.with_objects ? at_single_probe : without_objects;
  }
};

}  // namespace pleinair
