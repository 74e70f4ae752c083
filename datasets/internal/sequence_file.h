// Finds and checks the file that describes a sequence.
#pragma once

#include <filesystem>

#include "calib/json_cursor.h"

namespace pleinair {

// `folder`/sequence.json. Throws JsonError, with what to do, where somebody has given something
// else.
std::filesystem::path SequenceFileIn(const std::filesystem::path& folder);

// Throws JsonError where the key `format` exists and is neither a sequence's nor a site's.
void CheckFormat(const JsonCursor& root);

}  // namespace pleinair
