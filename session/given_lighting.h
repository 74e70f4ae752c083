// `run --lighting FILE`: a lighting.jsonl whose light replaces the estimate.
#pragma once

#include <filesystem>
#include <map>

#include "datasets/sequence.h"
#include "estimation/given_lighting_source.h"

namespace pleinair {

// Returns the light by frame, without lines of failed frames. Throws std::runtime_error naming
// file, frame, key and what was expected, for a line without light, a light that GivenLight
// refuses, or a missing sky image.
std::map<int, GivenLight> ReadGivenLighting(const std::filesystem::path& file);

// Throws std::runtime_error naming file and frame where light of `file` is of another time than
// that frame of `sequence`: before frames that would all fail for it.
void RequireLightingOf(const Sequence& sequence, const std::filesystem::path& file);

}  // namespace pleinair
