// Values of a sequence's JSON. Each throws JsonError naming the key and what was expected.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "calib/json_cursor.h"
#include "datasets/sequence.h"

namespace pleinair {

inline constexpr std::size_t kAnyCount = static_cast<std::size_t>(-1);
inline constexpr int kMaxImageSidePx = 65536;

template <typename Read>
auto ReadOptional(const JsonCursor& at, std::string_view key, const Read& read)
    -> std::optional<decltype(read(at))> {
  const auto found = at.Optional(key);
  if (!found) return std::nullopt;
  return read(*found);
}

glm::dvec2 ReadVector2(const JsonCursor& at);
glm::dmat4 ReadRigid(const JsonCursor& at);
glm::dmat4 ReadInvertible(const JsonCursor& at);
UtcTime ReadTime(const JsonCursor& at);
std::vector<std::string> ReadTexts(const JsonCursor& at);
Weather ReadWeather(const JsonCursor& at);
CameraIntrinsics ReadIntrinsics(const JsonCursor& at);
// `pose_uncertain_deg` of a camera, in radians.
std::optional<double> ReadPoseStddevRad(const JsonCursor& camera);

// A path in `folder`, as written in the JSON: the file may be missing.
std::filesystem::path ReadPathInside(const JsonCursor& at, const std::filesystem::path& folder);
std::filesystem::path ReadExistingFile(const JsonCursor& at, const std::filesystem::path& folder);

}  // namespace pleinair
