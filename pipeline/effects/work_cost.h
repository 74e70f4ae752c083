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

// Of light on the objects, by the ways of finding it.
struct LightCosts {
  LightCost at_vertices;
  LightCost at_one_place;
  LightCost alone;   // At one place, without what objects do to each other.
  WorkCost between;  // That, at vertices, where it is a work of its own.
  bool between_is_apart = false;

  bool AnyHasOlder() const {
    return at_vertices.HasOlder() || at_one_place.HasOlder() || alone.HasOlder();
  }
  const LightCost& Of(const VertexLight::Mode& mode) const {
    if (mode.at == VertexLight::At::kVertices) return at_vertices;
    return mode.with_objects ? at_one_place : alone;
  }
};

}  // namespace pleinair
