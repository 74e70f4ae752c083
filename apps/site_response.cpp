#include "apps/site_response.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "datasets/site_file.h"
#include "scene/whole_file.h"

namespace pleinair {

std::string ResponseNameIn(const std::filesystem::path& file) {
  const nlohmann::json document = LoadJson(file);
  std::string response = "srgb8";
  if (const auto radiometry = JsonCursor(document, file.string()).Optional("radiometry")) {
    if (const auto ldr = radiometry->Optional("frames_ldr")) response = ldr->Text();
  }
  return response == "srgb8" ? response : (file.parent_path() / response).string();
}

void WriteSiteResponse(const std::string& response,
                       const std::filesystem::path& file,
                       const std::filesystem::path& out) {
  WriteWholeText(out.parent_path() / kSiteResponseFile, response);
  EditSiteFile(
      file,
      [](nlohmann::ordered_json& json) { json["radiometry"]["frames_ldr"] = kSiteResponseFile; },
      out);
}

double WriteTiedResponse(const ResponseCurve& response,
                         const ColourTie& tie,
                         const std::filesystem::path& file,
                         const std::filesystem::path& out) {
  const glm::dvec3 factor(tie.to_from_rgb[0][0], tie.to_from_rgb[1][1], tie.to_from_rgb[2][2]);
  WriteSiteResponse(ResponseCurve::FromTable(TiedResponse(response, factor)).FileText(), file, out);
  return std::max({factor.x, factor.y, factor.z});
}

}  // namespace pleinair
