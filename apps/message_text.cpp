#include "apps/message_text.h"

#include <algorithm>

#include <fmt/format.h>

namespace pleinair {
namespace {

constexpr std::size_t kMostBytes = 2000;

// How many bytes the printable character at the beginning has; 0: there is none.
std::size_t PrintableBytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7f ? 1 : 0;
  const std::size_t length = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : byte(0) >= 0xc2 ? 2 : 0;
  if (length == 0 || byte(0) > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool is_c1_control = byte(0) == 0xc2 && byte(1) < 0xa0;
  return is_c1_control ? 0 : length;
}

// Byte by byte: bytes that are no character have no other form.
void AppendEscapedByte(char byte, std::string& shown) {
  shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
}

}  // namespace

std::string MessageText(std::string_view text) {
  std::string shown;
  while (!text.empty() && shown.size() < kMostBytes) {
    const std::size_t bytes = PrintableBytes(text);
    if (bytes > 0) {
      shown.append(text.substr(0, bytes));
    } else {
      AppendEscapedByte(text.front(), shown);
    }
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  if (!text.empty()) shown += fmt::format("... ({} more bytes)", text.size());
  return shown;
}

std::string OutputText(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const auto first = static_cast<unsigned char>(text.front());
    std::size_t bytes = PrintableBytes(text);
    if (bytes > 0 || first == '\n' || first == '\t') {
      bytes = std::max<std::size_t>(bytes, 1);
      shown.append(text.substr(0, bytes));
    } else if (first < 0x80) {
      bytes = 1;
      shown += fmt::format("\\u{:04x}", first);
    } else if (first == 0xc2 && text.size() > 1 && (text[1] & 0xc0) == 0x80) {
      bytes = 2;  // A control character above 0x7f, whose number is that of its second byte.
      shown += fmt::format("\\u{:04x}", static_cast<unsigned char>(text[1]));
    } else {
      bytes = 1;
      AppendEscapedByte(text.front(), shown);
    }
    text.remove_prefix(bytes);
  }
  return shown;
}

}  // namespace pleinair
