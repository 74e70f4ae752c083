// A fixed camera's stated pose, corrected where the sequence's frames show the mesh elsewhere.
#pragma once

#include <string>

#include "datasets/sequence.h"
#include "scene/mesh.h"
#include "session/session_options.h"

namespace pleinair {

// Puts the corrected pose into the sequence; `mesh` is its scene's. Up to five frames are looked
// at, spread over the recording, since shadows have edges, too, and move. Returns what was found,
// as a line of text; empty where the stated pose stays. It stays for a camera that moves, for a
// site without frames, where it is stated as exact, and where frames do not contradict it.
//
// Cost  about 0.5 s for a camera of 640 x 480.
std::string CorrectPose(const SessionOptions& options, const Mesh& mesh, Sequence& sequence);

}  // namespace pleinair
