// `run --lighting FILE`: a lighting.jsonl as the light to use in place of an estimate.
#pragma once

#include <filesystem>
#include <map>

#include "estimation/given_lighting_source.h"

namespace pleinair {

// Lighting by frame, without lines of failed frames. Throws std::runtime_error naming file,
// frame, key and what was expected: no light in a line, a light that GivenLight refuses, a sky
// image that is not there.
std::map<int, GivenLight> ReadGivenLighting(const std::filesystem::path& file);

}  // namespace pleinair
