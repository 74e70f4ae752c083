#include "scene/internal/picture_format.h"

#include <algorithm>
#include <fstream>
#include <string>

#include "scene/whole_file.h"

namespace pleinair {
namespace {

constexpr std::size_t kFirstBytes = 256;

// A file that begins with `first` and has `second` from byte `offset` on.
struct Signature {
  std::string_view first;
  std::size_t offset;
  std::string_view second;
  std::string_view what;
  PictureFormat format = PictureFormat::kNone;
};

// The first that fits counts. ISO media files (ISO 14496-12) have their brand behind "ftyp".
constexpr Signature kSignatures[] = {
    {"\x76\x2f\x31\x01", 0, "", "an OpenEXR picture", PictureFormat::kExr},
    {"#?", 0, "", "a Radiance HDR picture", PictureFormat::kRadianceHdr},
    {"\x89PNG", 0, "", "a PNG picture", PictureFormat::kPng},
    {"\xff\xd8", 0, "", "a JPEG picture", PictureFormat::kJpeg},
    {"GIF8", 0, "", "a GIF picture"},
    {"II*", 0, "", "a TIFF picture or a camera's raw file"},
    {std::string_view("MM\0*", 4), 0, "", "a TIFF picture or a camera's raw file"},
    {"8BPS", 0, "", "a Photoshop picture"},
    {"BM", 6, std::string_view("\0\0\0\0", 4), "a BMP picture"},
    {"RIFF", 8, "WEBP", "a WebP picture"},
    {"RIFF", 8, "AVI ", "an AVI video"},
    {"", 4, "ftyphei", "a HEIC picture"},
    {"", 4, "ftypmif1", "a HEIC picture"},
    {"", 4, "ftypavif", "an AVIF picture"},
    {"", 4, "ftypqt", "a QuickTime video"},
    {"", 4, "ftyp", "an MP4 video"},
    {"", 4, "moov", "a QuickTime video"},
    {"\x1a\x45\xdf\xa3", 0, "", "a Matroska or WebM video"},
    {std::string_view("\0\0\1\xba", 4), 0, "", "an MPEG video"},
};

std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

const Signature* SignatureOf(std::span<const std::byte> bytes) {
  const std::string_view text = AsText(bytes);
  for (const Signature& signature : kSignatures) {
    if (text.starts_with(signature.first) && text.size() >= signature.offset &&
        text.substr(signature.offset).starts_with(signature.second)) {
      return &signature;
    }
  }
  return nullptr;
}

}  // namespace

PictureFormat PictureFormatOf(std::span<const std::byte> bytes) {
  const Signature* const signature = SignatureOf(bytes);
  return signature == nullptr ? PictureFormat::kNone : signature->format;
}

std::string_view DescribeBytes(std::span<const std::byte> bytes) {
  const Signature* const signature = SignatureOf(bytes);
  if (signature != nullptr) return signature->what;
  const std::string_view text = AsText(bytes);
  const bool is_text = std::all_of(text.begin(), text.end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code >= 32 || c == '\n' || c == '\r' || c == '\t';
  });
  return is_text ? "text" : "something else";
}

std::vector<std::byte> FirstBytes(const std::filesystem::path& file) {
  RequireFile(file);
  std::vector<std::byte> bytes(kFirstBytes);
  std::ifstream stream(file, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  if (bytes.empty()) RefuseFile(file, "cannot be read");
  return bytes;
}

}  // namespace pleinair
