#include "apps/whole_text.h"

#include <fstream>
#include <stdexcept>
#include <system_error>

namespace pleinair {

void WriteWholeText(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path unfinished = file;
  unfinished += ".part";
  std::error_code error;
  {
    std::ofstream stream(unfinished, std::ios::binary | std::ios::trunc);
    stream << text;
    stream.close();
    if (!stream) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) std::filesystem::rename(unfinished, file, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
  throw std::runtime_error(file.string() + ": cannot be written: " + error.message());
}

}  // namespace pleinair
