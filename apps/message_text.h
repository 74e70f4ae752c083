// What goes to a terminal.
#pragma once

#include <string>
#include <string_view>

namespace pleinair {

// One line of printable UTF-8, of 2000 bytes at most: names of files and keys of documents may hold
// anything. Control characters, and what is no UTF-8, are written as \xNN; what is cut off is
// counted.
std::string MessageText(std::string_view text);

}  // namespace pleinair
