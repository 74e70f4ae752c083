#include "scene/internal/mesh_file_check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "scene/whole_file.h"

namespace pleinair {

namespace {

constexpr std::array<std::string_view, 5> kPlyWords{
    "comment", "element", "format", "obj_info", "property"};

}  // namespace

void RequireSoundPlyHeader(const std::filesystem::path& file) {
  constexpr std::size_t kLongestHeader = std::size_t{1} << 16U;
  const std::uintmax_t file_bytes = std::filesystem::file_size(file);
  std::string text(std::min<std::uintmax_t>(kLongestHeader, file_bytes), '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream) RefuseFile(file, "cannot be read");

  // Where both kinds of line end stand by themselves, readers disagree on what a line is.
  const char line_end = text.find('\n') < text.find("end_header") ? '\n' : '\r';
  std::istringstream lines(text);
  std::string line;
  const auto read_line = [&] {
    if (!std::getline(lines, line, line_end)) return false;
    if (line_end == '\n' && !line.empty() && line.back() == '\r') line.pop_back();
    return true;
  };
  if (!read_line() || line != "ply") {
    RefuseFile(file, "expected a PLY file, which begins with `ply`");
  }
  int line_number = 1;
  while (read_line()) {
    if (line == "end_header") return;
    std::istringstream words(line);
    std::string word;
    std::string name;
    std::uint64_t count = 0;
    ++line_number;
    if (!(words >> word)) continue;
    if (line.find('\r') != std::string::npos ||
        std::find(kPlyWords.begin(), kPlyWords.end(), word) == kPlyWords.end()) {
      RefuseFile(file,
                 "line " + std::to_string(line_number) +
                     ": expected `comment`, `element`, `end_header`, `format`, `obj_info` or "
                     "`property` and its line's end");
    }
    if (word != "element") continue;
    // A minus sign makes it a number near 2^64.
    if (!(words >> name >> count) || count > file_bytes) {
      RefuseFile(file,
                 "`" + line.substr(0, 60) + "`: expected no more elements than the file has bytes");
    }
  }
  RefuseFile(file, "expected `end_header` within the first 64 KiB");
}

int JsonNesting(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;  // The next character ends no string.
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace pleinair
