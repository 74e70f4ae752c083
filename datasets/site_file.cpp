#include "datasets/site_file.h"

#include <cstddef>
#include <string>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "datasets/internal/sequence_folder.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::filesystem::path SiteFileIn(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_regular_file(folder, error)) return folder;
  for (const char* name : {"site.json", "sequence.json"}) {
    if (!std::filesystem::exists(folder / name, error)) continue;
    if (!ResolveInside(folder, name)) {
      RefuseFile(folder / name, "expected a file inside the site's folder");
    }
    return folder / name;
  }
  RefuseFile(folder, "expected a site's folder, with a site.json or a sequence.json in it");
}

void EditSiteFile(const std::filesystem::path& folder,
                  const std::function<void(Json&)>& edit,
                  const std::filesystem::path& out) {
  const std::filesystem::path file = SiteFileIn(folder);
  // The result is in alphabetical order: it is parsed only for its refusals.
  LoadJson(file);
  const std::vector<std::byte> bytes = ReadWholeFile(file);
  const Json before = Json::parse(bytes.begin(), bytes.end());
  if (!before.is_object()) RefuseFile(file, "expected an object");
  Json json = before;
  edit(json);
  if (!out.empty() || json != before) WriteJsonFile(json, out.empty() ? file : out);
}

void WriteJsonFile(const Json& json, const std::filesystem::path& file) {
  WriteWholeText(file, json.dump(1) + '\n');
}

Json JsonOf(const glm::dmat4& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row], matrix[3][row]});
  }
  return rows;
}

Json JsonOf(const CameraIntrinsics& camera) {
  return {{"width", camera.width_px},
          {"height", camera.height_px},
          {"fx", camera.fx_px},
          {"fy", camera.fy_px},
          {"cx", camera.cx_px},
          {"cy", camera.cy_px},
          {"distortion", camera.distortion},
          {"distortion_model", "opencv"},
          {"pixel_centers", "integer"}};
}

}  // namespace pleinair
