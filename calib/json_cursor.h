// Strict reading of JSON files that people write: every refusal names file, key and what was
// expected.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace pleinair {

// One line, "FILE: KEY.PATH[3]: expected a positive number, found "x"".
class JsonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Parses a complete file of at most 256 MiB.
// Throws  JsonError naming the file, and line and column where there is one: unreadable, not JSON,
//         not UTF-8, a key given twice, nested deeper than 64.
nlohmann::json LoadJson(const std::filesystem::path& file);

// The same for text; `label` stands where the file's name would.
nlohmann::json ParseJson(std::string_view text, const std::string& label);

// A value and its place. Every function throws JsonError when the value is not of the expected
// kind. Keeps a reference to the document, which must outlive it.
class JsonCursor {
 public:
  JsonCursor(const nlohmann::json& value, std::string file);

  const nlohmann::json& Value() const { return *value_; }
  // "camera.fx"; empty for the document itself.
  const std::string& Path() const { return path_; }

  [[noreturn]] void Fail(const std::string& expected) const;
  // The same for a missing key of this object.
  [[noreturn]] void FailMissing(std::string_view key, const std::string& expected) const;

  // The value is an object whose keys are all in `known`, or free: `name`, and those that begin
  // with note, formula or world, whose values may be anything.
  void CheckKeys(std::initializer_list<std::string_view> known) const;

  JsonCursor Required(std::string_view key) const;
  std::optional<JsonCursor> Optional(std::string_view key) const;

  // The entries of a list of `count_min` to `count_max`.
  std::vector<JsonCursor> List(std::size_t count_min, std::size_t count_max) const;

  // The entries of an object whose keys are names.
  struct Entry;
  std::vector<Entry> Entries() const;

  double Number() const;
  double PositiveNumber() const;
  double NumberIn(double low, double high) const;
  int IntegerIn(int low, int high) const;
  bool Boolean() const;
  std::string Text() const;  // Not empty.
  // The text of a key that is free; empty where the value is none.
  std::string FreeText() const;
  // The text, which is one of `allowed`.
  std::string OneOf(std::initializer_list<std::string_view> allowed) const;

 private:
  JsonCursor(const nlohmann::json& value, std::string file, std::string path);
  std::string PathOf(std::string_view key) const;

  const nlohmann::json* value_;
  std::string file_;
  std::string path_;
};

struct JsonCursor::Entry {
  std::string key;
  JsonCursor at;
};

}  // namespace pleinair
