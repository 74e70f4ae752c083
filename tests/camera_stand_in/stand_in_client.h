// Programs under the stand-in: camera_client.cpp as a stranger's program, and what it reports.
//
// Nothing in these tests depends on how fast the machine is: times are those that the buffers
// state, and a slow client loses pictures, which the tests allow for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/scene/shell.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair {

inline const std::filesystem::path kCourtyard =
    std::filesystem::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";
inline constexpr int kPictures = 6;
inline constexpr int kWidth = 480;
inline constexpr int kHeight = 360;
inline constexpr std::int64_t kSecondNs = 1'000'000'000;
inline constexpr std::int64_t kMicrosecondNs = 1'000;  // What a buffer's timestamp is rounded to.

// Reading the two clocks takes some of it, on a busy machine.
inline constexpr std::int64_t kClockReadingNs = kSecondNs / 1000;

// Of the client: a line of JSON for each buffer, error and call.
struct ClientRun : Ended {
  std::vector<nlohmann::json> Lines() const {
    std::vector<nlohmann::json> lines;
    std::istringstream stream(output);
    for (std::string line; std::getline(stream, line);) {
      lines.push_back(nlohmann::json::parse(line));
    }
    return lines;
  }
  std::vector<nlohmann::json> With(const std::string& key) const {
    std::vector<nlohmann::json> found;
    for (const nlohmann::json& line : Lines()) {
      if (line.contains(key)) found.push_back(line);
    }
    return found;
  }
  std::vector<nlohmann::json> Frames() const { return With("sequence"); }
};

inline ClientRun Program(const std::string& arguments) {
  return {StandardOutputOf(std::string(PLEINAIR_STAND_IN) + " " + arguments)};
}

// `sequence` and options of the stand-in, then the client's mode, device and options.
inline ClientRun StandIn(const std::string& options,
                         const std::string& client,
                         const std::filesystem::path& sequence = kCourtyard) {
  return Program("'" + sequence.string() + "' " + options + " -- " + PLEINAIR_CAMERA_CLIENT + " " +
                 client);
}

}  // namespace pleinair
