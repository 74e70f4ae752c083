// Text inside of HTML.
#pragma once

#include <string>

namespace pleinair {

// What HTML would read as its own, written so that it is shown.
std::string EscapeHtml(const std::string& text);

}  // namespace pleinair
