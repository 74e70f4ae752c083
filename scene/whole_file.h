// Files that are either complete or absent.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace pleinair {

// Throws std::runtime_error: the file and why.
[[noreturn]] void RefuseFile(const std::filesystem::path& file, const std::string& why);

// Throws std::runtime_error naming it unless `file` is a regular file that is not empty.
void RequireFile(const std::filesystem::path& file);

// The bytes of a regular file. Throws std::runtime_error naming it when it cannot be read or is
// empty.
std::vector<std::byte> ReadWholeFile(const std::filesystem::path& file);

// Throws std::runtime_error naming it unless `file` is a regular file, or a link to one, or absent.
// A device, a pipe or a folder must not be replaced by a file.
void RequireReplaceable(const std::filesystem::path& file);

// Makes the folder, and those that it lies in, unless it is there. Throws std::runtime_error naming
// it.
void MakeFolder(const std::filesystem::path& folder);

// Writes `bytes` to a temporary file beside `file` (".NAME.PID.N.part") and renames it: `file` is
// replaced completely or not at all. Throws std::runtime_error naming it when that fails, or as
// RequireReplaceable; the temporary file is removed then.
void WriteWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);
void WriteWholeText(const std::filesystem::path& file, const std::string& text);

// Calls `fill` with a new temporary folder beside `folder` (".NAME.PID.part") and renames it:
// `folder`, absent or empty before, is there completely or not at all. Throws what `fill` throws,
// and std::runtime_error naming the folder; the temporary one is removed then.
void WriteWholeFolder(const std::filesystem::path& folder,
                      const std::function<void(const std::filesystem::path&)>& fill);

}  // namespace pleinair
