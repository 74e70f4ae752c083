#include "datasets/judged_sunshine.h"

#include <filesystem>

#include "calib/json_cursor.h"

namespace pleinair {
namespace {

std::optional<bool> ReadWord(const JsonCursor& at) {
  const std::string word = at.OneOf({"sun", "none", "unclear"});
  if (word == "unclear") return std::nullopt;
  return word == "sun";
}

}  // namespace

std::vector<std::optional<bool>> ReadJudgedSunshine(const Sequence& sequence) {
  std::vector<std::optional<bool>> shines(sequence.frames.size());
  const std::filesystem::path file = sequence.folder / "judged.json";
  if (!std::filesystem::exists(file)) return shines;
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  root.Required("format").OneOf({"pleinair-judged"});
  root.Required("version").IntegerIn(1, 1);
  root.CheckKeys({"format", "version", "sun"});
  const JsonCursor sun = root.Required("sun");
  if (sun.Value().is_array()) {
    const std::vector<JsonCursor> words = sun.List(shines.size(), shines.size());
    for (std::size_t i = 0; i < words.size(); ++i) shines[i] = ReadWord(words[i]);
  } else {
    shines.assign(shines.size(), ReadWord(sun));
  }
  return shines;
}

}  // namespace pleinair
