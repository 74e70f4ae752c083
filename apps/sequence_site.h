// A recorded sequence's files as what relight and render work on.
#pragma once

#include <string>
#include <vector>

#include "datasets/sequence.h"
#include "relight/prepared_scene.h"
#include "render/compositor.h"

namespace pleinair {

struct SequenceSite {
  SiteModel model;
  std::vector<VirtualObject> objects;  // In world coordinates.
  BoundingBox probe_box;               // Around the objects, or around what the cameras look at.
  bool is_indoors = false;             // The first camera sees little of the sky.
  std::vector<std::string> notes;      // What was mended or assumed in loading.
};

// Loads mesh, environment map, mask and objects.
// Throws std::runtime_error, one line with the file and what was expected.
SequenceSite LoadSequenceSite(const Sequence& sequence);

// The options that `prepare` and `run` share, so that one finds what the other has stored.
PrepareOptions PrepareOptionsFor(const SequenceSite& site, int bounces);

}  // namespace pleinair
