// A fixed camera's stated pose, corrected where the sequence's frames show the mesh elsewhere.
#pragma once

#include <string>

#include "session/loaded_sequence.h"
#include "session/session_options.h"

namespace pleinair {

// Puts the corrected pose into the loaded sequence, whose site must be loaded. Up to five frames
// are looked at, spread over the recording, since shadows have edges, too, and move. Returns a note
// for the report; empty where the stated pose stays. It stays for a camera that moves, for a site
// without frames, where it is stated as exact, and where frames do not contradict it.
//
// Cost  about 0.2 s for a camera of 640 x 480.
std::string CorrectPoseOf(const SessionOptions& options, LoadedSequence& loaded);

}  // namespace pleinair
