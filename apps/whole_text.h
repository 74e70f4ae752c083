// Text files that are either complete or absent.
#pragma once

#include <filesystem>
#include <string>

namespace pleinair {

// Writes beside `file` and renames. Throws as WriteWholeFile.
void WriteWholeText(const std::filesystem::path& file, const std::string& text);

}  // namespace pleinair
