// A person's judgement, from the pictures, whether the sun shone in a sequence's frames. Only
// scoring may read this.
#pragma once

#include <optional>
#include <vector>

#include "datasets/sequence.h"

namespace pleinair {

// One entry for each frame, from judged.json beside sequence.json; none where the person could not
// judge, or there is no such file.
// Throws  JsonError naming file, key and what was expected; for another number of frames.
std::vector<std::optional<bool>> ReadJudgedSunshine(const Sequence& sequence);

}  // namespace pleinair
