// What goes to a terminal: all of it passes through one of these.
#pragma once

#include <string>
#include <string_view>

namespace pleinair {

// One line of printable UTF-8, of 2000 bytes at most: names of files and keys of documents may hold
// anything. Control characters, and what is no UTF-8, are written as \xNN; what is cut off is
// counted.
std::string MessageText(std::string_view text);

// Tables and JSON, of any length: lines and tabs are kept, other control characters are written as
// \uNNNN, which a JSON text reads back, and what is no UTF-8 as \xNN.
std::string OutputText(std::string_view text);

}  // namespace pleinair
