// Which file describes a sequence, and whether it does.
#pragma once

#include <filesystem>

#include "calib/json_cursor.h"

namespace pleinair {

// `folder`/sequence.json. Throws JsonError, with what to do, where somebody has given something
// else.
std::filesystem::path SequenceFileIn(const std::filesystem::path& folder);

// Throws JsonError where the key `format` is there and is no sequence's or site's.
void CheckFormat(const JsonCursor& root);

}  // namespace pleinair
