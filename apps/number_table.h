// Tables of numbers that people write: comma-separated, a row a line, `#` begins a remark.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pleinair {

// Numbers between commas. Throws std::invalid_argument naming `what` and the part that is no finite
// number.
std::vector<double> ParseNumbers(std::string_view text, const std::string& what);

// Rows of `columns` numbers each, empty lines left out. Throws std::runtime_error naming file, line
// and what was expected, also where there is no row at all.
std::vector<std::vector<double>> ReadNumberTable(const std::filesystem::path& file,
                                                 std::size_t columns);

}  // namespace pleinair
