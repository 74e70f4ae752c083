// Options of commands whose pictures have times.
#pragma once

#include <chrono>
#include <string>

#include "datasets/picture_source.h"

namespace CLI {
class App;
}  // namespace CLI

namespace pleinair {

// "10s", "2min", "1h", "0.5": a time above 0, of a day at most. Throws std::invalid_argument naming
// `option`.
std::chrono::nanoseconds ParseInterval(const std::string& text, const std::string& option);

// --start-time, --time-zone and --every, which set `times`: it must outlive `command`.
void AddPictureTimes(CLI::App& command, PictureTimes& times, const std::string& group);

}  // namespace pleinair
