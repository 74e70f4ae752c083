// The bundled courtyard for tests, whose suites share what they prepare.
#pragma once

#include <memory>

#include "session/session_options.h"
#include "tests/relight/memory_store.h"

namespace pleinair {

// One for all suites of a program, which find what another suite prepared from the same inputs.
inline std::shared_ptr<BlobStore> SharedStore() {
  static const auto kStore = std::make_shared<MemoryStore>();
  return kStore;
}

// Prepared as users have it.
inline SessionOptions BundledCourtyard() {
  SessionOptions options;
  options.sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  options.store = SharedStore();
  return options;
}

// For tests that do not judge its light.
inline SessionOptions CoarseCourtyard() {
  SessionOptions options = BundledCourtyard();
  options.prepare.patch_size_m = 4.0;
  options.prepare.rays = 64;
  options.prepare.probe_counts = {2, 2, 2};
  return options;
}

}  // namespace pleinair
