// Costs of pieces of work, as input of the plan.
#pragma once

#include "objects/vertex_light.h"

namespace pleinair {

// The expected cost of a piece of work.
struct WorkCost {
  double expected_ms = 0.0;  // As learned on this machine.
  double nominal_ms = 0.0;   // The same on every machine.
  bool is_kept = false;
  // Parts of expected_ms that later frames need not repeat where nothing moves, and until the sun
  // has moved on.
  double once_ms = 0.0;
  double sun_ms = 0.0;
};

// Cost of light that is recomputed as the sun moves: for lights never computed, and for lights of
// an older sun.
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
