// Options of commands whose camera may move: where its poses come from.
#pragma once

#include <string>

#include "session/session_options.h"

namespace CLI {
class App;
}  // namespace CLI

namespace pleinair {

// --markers and --poses, which set `options`: it must outlive `command`.
void AddPoseSources(CLI::App& command, SessionOptions& options, const std::string& group);

}  // namespace pleinair
