#include "apps/number_table.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "scene/trimmed.h"

namespace pleinair {

std::vector<double> ParseNumbers(std::string_view text, const std::string& what) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view part = Trimmed(text.substr(0, comma));
    double number = 0.0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error != std::errc() || end != part.data() + part.size() || !std::isfinite(number)) {
      throw std::invalid_argument(what + ": expected numbers between commas, found \"" +
                                  std::string(part) + "\"");
    }
    numbers.push_back(number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

std::vector<std::vector<double>> ReadNumberTable(const std::filesystem::path& file,
                                                 std::size_t columns) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": expected a readable file");
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // Spreadsheets' UTF-8.
    line.resize(std::min(line.find('#'), line.size()));
    if (Trimmed(line).empty()) continue;
    const std::string place = file.string() + ": line " + std::to_string(number);
    try {
      rows.push_back(ParseNumbers(line, place));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(error.what());
    }
    if (rows.back().size() != columns) {
      throw std::runtime_error(place + ": expected " + std::to_string(columns) +
                               " numbers, found " + std::to_string(rows.back().size()));
    }
  }
  if (rows.empty()) throw std::runtime_error(file.string() + ": expected one row or more");
  return rows;
}

}  // namespace pleinair
