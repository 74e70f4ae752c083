// Files of a sequence: inside its folder, and as its cameras see.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include <tl/expected.hpp>

#include "scene/image.h"

namespace pleinair {

// `folder` / `relative`, once it is clear that it does not leave the folder: neither by its text
// nor, as far as it exists, through symbolic links. Otherwise what was expected, in a few words.
tl::expected<std::filesystem::path, std::string> ResolveInside(
    const std::filesystem::path& folder, const std::filesystem::path& relative);

// The same for an existing file. Throws std::runtime_error naming it.
std::filesystem::path FileInside(const std::filesystem::path& folder,
                                 const std::filesystem::path& relative);

// Throws std::runtime_error unless `image` has the size of the camera under this key in
// sequence.json.
template <typename Pixel, typename Intrinsics>
void RequireCameraSize(const Image<Pixel>& image,
                       const Intrinsics& camera,
                       const std::string& key,
                       const std::filesystem::path& file) {
  if (image.width == camera.width_px && image.height == camera.height_px) return;
  throw std::runtime_error(file.string() + ": expected " + std::to_string(camera.width_px) + "x" +
                           std::to_string(camera.height_px) + " pixels, found " +
                           std::to_string(image.width) + "x" + std::to_string(image.height) + " (" +
                           key + ".width and " + key + ".height say the former)");
}

}  // namespace pleinair
