// A sequence's paths stay inside its folder.
#pragma once

#include <filesystem>

#include <tl/expected.hpp>

namespace pleinair {

// `folder` / `relative`, once it is clear that it does not leave the folder: neither by its text
// nor, as far as it exists, through symbolic links. Otherwise what was expected, in a few words.
tl::expected<std::filesystem::path, std::string> ResolveInside(
    const std::filesystem::path& folder, const std::filesystem::path& relative);

}  // namespace pleinair
