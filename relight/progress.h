// How far long work has come.
#pragma once

#include <functional>
#include <string_view>

namespace pleinair {

// Stage name and share done in [0, 1].
using Progress = std::function<void(std::string_view stage, double share)>;

}  // namespace pleinair
