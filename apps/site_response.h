// The response of a site's 8-bit camera: which one it is, and another one in its place.
#pragma once

#include <filesystem>
#include <string>

#include "calib/colour_tie.h"
#include "calib/response.h"

namespace pleinair {

// The response that is made for a site, beside its file.
inline constexpr const char* kSiteResponseFile = "camera_response.json";

// "srgb8", or the path of a response file, as ResponseFrom takes it. `file`: site.json or
// sequence.json. Throws std::runtime_error naming the key.
std::string ResponseNameIn(const std::filesystem::path& file);

// Makes `response`, the text of a response file, that of the camera in `file`; `out` may be `file`.
// Throws std::runtime_error naming the file.
void WriteSiteResponse(const std::string& response,
                       const std::filesystem::path& file,
                       const std::filesystem::path& out);

// The same of `response` with the factors of `tie`, a ColourTieKind::kScale. Returns the largest
// factor, which belongs to the exposure. Throws as TiedResponse, too.
double WriteTiedResponse(const ResponseCurve& response,
                         const ColourTie& tie,
                         const std::filesystem::path& file,
                         const std::filesystem::path& out);

}  // namespace pleinair
