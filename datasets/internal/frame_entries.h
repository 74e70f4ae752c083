// The frames of a sequence's JSON.
#pragma once

#include <filesystem>
#include <vector>

#include "calib/json_cursor.h"
#include "datasets/sequence.h"

namespace pleinair {

// Requirements of the sequence on its frames.
struct FrameRules {
  std::filesystem::path folder;
  std::filesystem::path file;  // For messages.
  bool have_fisheye = false;   // Frames may have a picture of the fish-eye camera.
  bool need_pose = true;
};

// `at`: a list, or the path of a file with a line a frame. Throws JsonError naming the key and what
// was expected.
std::vector<FrameEntry> ReadFrameEntries(const JsonCursor& at, const FrameRules& rules);

}  // namespace pleinair
