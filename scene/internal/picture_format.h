// The kind of a file by its first bytes, since a file's name is not reliable.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace pleinair {

enum class PictureFormat { kExr, kRadianceHdr, kPng, kJpeg, kNone };

PictureFormat PictureFormatOf(std::span<const std::byte> bytes);

// A description for messages: "a JPEG picture", "an MP4 video", "text", "something else".
std::string_view DescribeBytes(std::span<const std::byte> bytes);

// As many bytes as these functions read, or as the file has. Throws std::runtime_error naming the
// file unless it is a regular file with something in it.
std::vector<std::byte> FirstBytes(const std::filesystem::path& file);

}  // namespace pleinair
