// Checks of a mesh file's own data before its reader spends time or memory on it.
#pragma once

#include <filesystem>
#include <string_view>

namespace pleinair {

// Refuses promises of more elements than the file has bytes, lines of another kind than a header
// has, and a header that does not end in its own kind of line end: assimp reads on past the end of
// the file, 20 s and more. Throws std::runtime_error naming the file.
void RequireSoundPlyHeader(const std::filesystem::path& file);

// Largest nesting of lists and objects in a JSON text; any number for other text.
int JsonNesting(std::string_view text);

}  // namespace pleinair
