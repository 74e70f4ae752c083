#include "apps/whole_text.h"

#include <span>

#include "scene/whole_file.h"

namespace pleinair {

void WriteWholeText(const std::filesystem::path& file, const std::string& text) {
  WriteWholeFile(file, std::as_bytes(std::span(text)));
}

}  // namespace pleinair
