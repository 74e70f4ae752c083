// The file of a site: site.json, or else a sequence's sequence.json. Its keys are changed here and
// not by WriteSequence, which would lose notes and the order of keys.
#pragma once

#include <filesystem>
#include <functional>

#include <glm/mat4x4.hpp>
#include <nlohmann/json_fwd.hpp>

#include "scene/camera.h"

namespace pleinair {

// Returns `folder`/site.json where it exists, else `folder`/sequence.json; such a file may be given
// itself. Throws std::runtime_error, naming the folder, where there is neither.
std::filesystem::path SiteFileIn(const std::filesystem::path& folder);

// Changes the file of SiteFileIn by `edit`. Other keys keep their order and values. Nothing is
// written where `edit` changes nothing, or throws. With `out`, that file is always written, and the
// site's is not changed.
// Throws  std::runtime_error, one line with the file: as SiteFileIn, for what is not a JSON object,
//         and as WriteWholeFile; what `edit` throws.
void EditSiteFile(const std::filesystem::path& folder,
                  const std::function<void(nlohmann::ordered_json&)>& edit,
                  const std::filesystem::path& out = {});

// Writes `json` as `file`, completely or not at all, with one value a line. Throws as
// WriteWholeFile.
void WriteJsonFile(const nlohmann::ordered_json& json, const std::filesystem::path& file);

// In the form of the keys: a list of rows; width, height, fx, fy, cx, cy, distortion and their
// conventions.
nlohmann::ordered_json JsonOf(const glm::dmat4& matrix);
nlohmann::ordered_json JsonOf(const CameraIntrinsics& camera);

}  // namespace pleinair
