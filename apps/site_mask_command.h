// `pleinair site mask`: what moves in a recording, as a mask of what may be sampled.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/moving_things.h"
#include "session/session_options.h"

namespace pleinair {

struct SiteMaskOptions {
  SessionOptions session;
  MovingThingsOptions moving;
  int frames = 64;                 // At most, spread evenly over the recording. >= 3.
  std::filesystem::path out;       // The mask as PNG; empty: not written.
  std::filesystem::path overview;  // The first frame with what is masked, as PNG; empty: none.
  bool write = false;              // To the sequence, together with the mask that it has.
};

// Writes the files asked for, each completely or not at all, and returns the report. Throws
// std::runtime_error or std::invalid_argument, one line.
std::string RunSiteMask(const SiteMaskOptions& options);

}  // namespace pleinair
