// Whether the sun shone in a sequence's frames, as a person judged it from the pictures. Scoring
// alone may read this.
#pragma once

#include <optional>
#include <vector>

#include "datasets/sequence.h"

namespace pleinair {

// One entry a frame, from judged.json beside sequence.json; none where the person could not say, or
// there is no such file.
// Throws  JsonError naming file, key and what was expected; for another number of frames.
std::vector<std::optional<bool>> ReadJudgedSunshine(const Sequence& sequence);

}  // namespace pleinair
