#include "datasets/camera_file.h"

#include <span>
#include <string>
#include <system_error>

#include "calib/json_cursor.h"
#include "scene/whole_file.h"

namespace pleinair {

std::filesystem::path CameraFileIn(const std::filesystem::path& file_or_folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(file_or_folder, error)) return file_or_folder;
  const std::filesystem::path site = file_or_folder / "site.json";
  return std::filesystem::exists(site, error) ? site : file_or_folder / "sequence.json";
}

void MergeIntoFile(const std::filesystem::path& file,
                   const nlohmann::ordered_json& changes,
                   const std::filesystem::path& out) {
  LoadJson(file);  // Refuses, in one line, what cannot be read.
  const std::vector<std::byte> bytes = ReadWholeFile(file);
  const char* const begin = reinterpret_cast<const char*>(bytes.data());
  nlohmann::ordered_json document = nlohmann::ordered_json::parse(begin, begin + bytes.size());
  document.merge_patch(changes);
  const std::string text = document.dump(1) + "\n";
  WriteWholeFile(out, std::as_bytes(std::span(text)));
}

nlohmann::ordered_json JsonOf(const glm::dmat4& matrix) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row], matrix[3][row]});
  }
  return rows;
}

nlohmann::ordered_json JsonOf(const CameraIntrinsics& camera) {
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
