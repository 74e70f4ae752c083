// Checks of a mesh file's own data before its reader spends time or memory on it.
#pragma once

#include <filesystem>
#include <string_view>

namespace pleinair {

// Refuses promises of more elements than the file has bytes, and lines of another kind than a
// header has. Also a header that does not end in its own kind of line end: there assimp reads past
// the end of the file, for 20 s and more. Throws std::runtime_error naming the file.
void RequireSoundPlyHeader(const std::filesystem::path& file);

// Largest nesting of lists and objects in a JSON text; any number for other text.
int JsonNesting(std::string_view text);

}  // namespace pleinair
