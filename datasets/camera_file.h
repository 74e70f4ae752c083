// The file of a site or sequence, changed key by key: what commands and the window write into it.
#pragma once

#include <filesystem>

#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>

#include "scene/camera.h"

namespace pleinair {

// site.json of a folder, or its sequence.json where there is no site.json; anything but a folder is
// taken to be the file itself.
std::filesystem::path CameraFileIn(const std::filesystem::path& file_or_folder);

// Writes `out` as the JSON file `file` with `changes` merged into it (RFC 7396: objects are merged
// key by key, null removes a key, all else replaces what is there). Keys keep their order, new ones
// come last. `out` may be `file`; it is written completely or not at all.
// Throws  std::runtime_error, one line: `file` as LoadJson, `out` as WriteWholeFile.
void MergeIntoFile(const std::filesystem::path& file,
                   const nlohmann::ordered_json& changes,
                   const std::filesystem::path& out);

// As the keys of `camera` have them: a list of rows.
nlohmann::ordered_json JsonOf(const glm::dmat4& matrix);
// width, height, fx, fy, cx, cy, distortion and what they mean.
nlohmann::ordered_json JsonOf(const CameraIntrinsics& camera);

}  // namespace pleinair
