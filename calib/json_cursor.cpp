#include "calib/json_cursor.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

namespace pleinair {
namespace {

// Deeper than any of our formats, and far from what the stack of a recursive walk would hold.
constexpr std::size_t kMaxDepth = 64;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{256} << 20;
constexpr std::size_t kMaxQuotedCharacters = 60;

std::string Quoted(std::string_view text) {
  const bool cut = text.size() > kMaxQuotedCharacters;
  // dump() escapes control characters, so that the message stays one line; a character cut in half
  // is replaced.
  std::string quoted = nlohmann::json(std::string(text.substr(0, kMaxQuotedCharacters)))
                           .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return cut ? quoted + "..." : quoted;
}

// " (1, 2.5, 3)" of a short list that has numbers alone.
std::string ListedNumbers(const nlohmann::json& list) {
  constexpr std::size_t kMostListed = 4;
  if (list.empty() || list.size() > kMostListed) return {};
  std::string text;
  for (const nlohmann::json& entry : list) {
    if (!entry.is_number()) return {};
    text += (text.empty() ? " (" : ", ") + entry.dump();
  }
  return text + ")";
}

std::string Described(const nlohmann::json& value) {
  switch (value.type()) {
    case nlohmann::json::value_t::object:
      return "an object";
    case nlohmann::json::value_t::array:
      return "a list of " + std::to_string(value.size()) + ListedNumbers(value);
    case nlohmann::json::value_t::string:
      return Quoted(value.get_ref<const std::string&>());
    default:
      return value.dump();
  }
}

std::string ShortestText(double value) { return nlohmann::json(value).dump(); }

std::string Alternatives(std::initializer_list<std::string_view> allowed) {
  std::string text;
  for (const std::string_view one : allowed) {
    text += (text.empty() ? "" : " or ") + Quoted(one);
  }
  return text;
}

std::string LineAndColumn(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte == 0 ? 0 : byte - 1, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n');
  const std::size_t column =
      before.size() - (line_start == std::string_view::npos ? 0 : line_start + 1) + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

// What stands where the parser stopped, in printable characters. NaN and infinities, which other
// programs write, are no JSON.
std::string WordAt(std::string_view text, std::size_t byte) {
  constexpr std::string_view kBetween = " \t\r\n,:[]{}\"";
  constexpr std::size_t kMostShown = 20;
  const auto is_word = [&](std::size_t at) {
    return kBetween.find(text[at]) == std::string_view::npos;
  };
  const std::size_t stop = std::min(byte == 0 ? 0 : byte - 1, text.size());
  if (stop == text.size()) return "the end of the text";
  std::size_t begin = stop;
  std::size_t end = stop + 1;
  const std::size_t open = stop == 0 ? std::string_view::npos : text.rfind('"', stop - 1);
  if (text[stop] == '"' && open != std::string_view::npos && stop - open < kMostShown) {
    begin = open + 1;  // The parser stops at the end of a text, which stands for itself.
    end = stop;
  } else if (is_word(stop)) {
    while (begin > 0 && is_word(begin - 1) && stop - begin < kMostShown / 2) --begin;
    while (end < text.size() && is_word(end) && end - begin < kMostShown) ++end;
  }
  std::string word(text.substr(begin, end - begin));
  for (char& letter : word) {
    if (letter < 0x20 || letter > 0x7e) letter = '?';
  }
  return Quoted(word);
}

// Refuses what the parser would let pass: keys given twice and deep nesting. It is a separate pass
// over the text. The parser's callback could do the same, but makes the parser walk each list at
// the end of each of its objects, in quadratic time.
class StructureCheck final : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit StructureCheck(const std::string& label) : label_(label) {}

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return Begin(); }
  bool start_array(std::size_t) override { return Begin(); }
  bool end_object() override { return End(); }
  bool end_array() override { return End(); }
  bool key(string_t& key) override {
    if (!keys_.back().insert(key).second) {
      throw JsonError(label_ + ": expected each key once, found " + Quoted(key) + " twice");
    }
    return true;
  }
  // Left to the parser, which says what is wrong.
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  bool Begin() {
    if (keys_.size() >= kMaxDepth) {
      throw JsonError(label_ + ": expected at most " + std::to_string(kMaxDepth) +
                      " levels of nesting, found more");
    }
    keys_.emplace_back();
    return true;
  }
  bool End() {
    keys_.pop_back();
    return true;
  }

  const std::string& label_;
  std::vector<std::set<std::string>> keys_;  // Keys of each open object; empty for a list.
};

}  // namespace

nlohmann::json LoadJson(const std::filesystem::path& file) {
  const std::string label = file.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw JsonError(label + ": expected a JSON file, found " +
                    (std::filesystem::exists(file, error) ? "something else" : "nothing"));
  }
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error || bytes > kMaxFileBytes) {
    throw JsonError(label + ": expected a JSON file of at most " +
                    std::to_string(kMaxFileBytes >> 20) + " MiB");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(static_cast<std::size_t>(bytes), '\0');
  if (!stream || !stream.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw JsonError(label + ": expected a readable file");
  }
  return ParseJson(text, label);
}

nlohmann::json ParseJson(std::string_view text, const std::string& label) {
  StructureCheck check(label);
  nlohmann::json::sax_parse(text.begin(), text.end(), &check);
  try {
    return nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::parse_error& error) {
    throw JsonError(label + ": " + LineAndColumn(text, error.byte) +
                    ": expected valid JSON in UTF-8, found " + WordAt(text, error.byte));
  } catch (const nlohmann::json::exception&) {
    throw JsonError(label + ": expected valid JSON, found a number too large to hold");
  }
}

JsonCursor::JsonCursor(const nlohmann::json& value, std::string file)
    : JsonCursor(value, std::move(file), "") {}

JsonCursor::JsonCursor(const nlohmann::json& value, std::string file, std::string path)
    : value_(&value), file_(std::move(file)), path_(std::move(path)) {}

std::string JsonCursor::PathOf(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void JsonCursor::Fail(const std::string& expected) const {
  throw JsonError(file_ + ": " + (path_.empty() ? "" : path_ + ": ") + "expected " + expected +
                  ", found " + Described(*value_));
}

void JsonCursor::FailMissing(std::string_view key, const std::string& expected) const {
  throw JsonError(file_ + ": " + PathOf(key) + ": expected " + expected + ", found none");
}

void JsonCursor::CheckKeys(std::initializer_list<std::string_view> known) const {
  if (!value_->is_object()) Fail("an object");
  for (const auto& [key, ignored] : value_->items()) {
    const bool is_free = key == "name" || key.starts_with("note") || key.starts_with("formula") ||
                         key.starts_with("world");
    const bool is_known = std::find(known.begin(), known.end(), key) != known.end();
    if (is_free || is_known) continue;
    throw JsonError(file_ + ": " + (path_.empty() ? "" : path_ + ": ") +
                    "expected only known keys (" + Alternatives(known) + "), found " + Quoted(key));
  }
}

JsonCursor JsonCursor::Required(std::string_view key) const {
  std::optional<JsonCursor> found = Optional(key);
  if (!found) FailMissing(key, "a value");
  return *found;
}

std::optional<JsonCursor> JsonCursor::Optional(std::string_view key) const {
  if (!value_->is_object()) Fail("an object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return JsonCursor(*found, file_, PathOf(key));
}

std::vector<JsonCursor> JsonCursor::List(std::size_t count_min, std::size_t count_max) const {
  if (!value_->is_array() || value_->size() < count_min || value_->size() > count_max) {
    if (count_min == count_max) Fail("a list of " + std::to_string(count_min));
    Fail(count_max == static_cast<std::size_t>(-1)
             ? "a list of at least " + std::to_string(count_min)
             : "a list of " + std::to_string(count_min) + " to " + std::to_string(count_max));
  }
  std::vector<JsonCursor> entries;
  entries.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    entries.push_back(JsonCursor((*value_)[i], file_, path_ + "[" + std::to_string(i) + "]"));
  }
  return entries;
}

std::vector<JsonCursor::Entry> JsonCursor::Entries() const {
  if (!value_->is_object()) Fail("an object");
  std::vector<Entry> entries;
  for (const auto& [key, value] : value_->items()) {
    entries.push_back({key, JsonCursor(value, file_, PathOf(key))});
  }
  return entries;
}

double JsonCursor::Number() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>())) Fail("a number");
  return value_->get<double>();
}

double JsonCursor::PositiveNumber() const {
  // Positive as a double; what later steps divide by must not be denormal either.
  if (!value_->is_number() || !std::isnormal(value_->get<double>()) ||
      !(value_->get<double>() > 0.0)) {
    Fail("a positive number");
  }
  return value_->get<double>();
}

double JsonCursor::NumberIn(double low, double high) const {
  const bool right =
      value_->is_number() && value_->get<double>() >= low && value_->get<double>() <= high;
  if (!right) Fail("a number from " + ShortestText(low) + " to " + ShortestText(high));
  return value_->get<double>();
}

int JsonCursor::IntegerIn(int low, int high) const {
  // 480.0 is an integer to a person; 480.5 is not.
  const double value = value_->is_number() ? value_->get<double>() : std::nan("");
  const bool right = value >= low && value <= high && value == std::floor(value);
  if (!right) Fail("an integer from " + std::to_string(low) + " to " + std::to_string(high));
  return static_cast<int>(value);
}

bool JsonCursor::Boolean() const {
  if (!value_->is_boolean()) Fail("true or false");
  return value_->get<bool>();
}

std::string JsonCursor::Text() const {
  if (!value_->is_string() || value_->get_ref<const std::string&>().empty()) Fail("a text");
  return value_->get<std::string>();
}

std::string JsonCursor::FreeText() const {
  return value_->is_string() ? value_->get<std::string>() : std::string();
}

std::string JsonCursor::OneOf(std::initializer_list<std::string_view> allowed) const {
  const bool right =
      value_->is_string() &&
      std::find(allowed.begin(), allowed.end(), value_->get_ref<const std::string&>()) !=
          allowed.end();
  if (!right) Fail(Alternatives(allowed));
  return value_->get<std::string>();
}

}  // namespace pleinair
