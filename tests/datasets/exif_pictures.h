// JPEGs with what cameras write into them: times and exposure.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

#include <libexif/exif-data.h>

namespace pleinair::made_pictures {

struct ExifTags {
  std::string time;  // "2026:06:21 12:00:00"
  std::string decimals;
  std::string offset;
  bool has_exposure = false;
};

inline void AddEntry(
    ExifData* data, ExifTag tag, ExifFormat format, unsigned count, const std::string& bytes) {
  ExifEntry* entry = exif_entry_new();
  entry->tag = tag;
  entry->format = format;
  entry->components = count;
  entry->size = static_cast<unsigned>(bytes.size());
  entry->data = static_cast<unsigned char*>(std::malloc(bytes.size()));
  std::memcpy(entry->data, bytes.data(), bytes.size());
  exif_content_add_entry(data->ifd[EXIF_IFD_EXIF], entry);
  exif_entry_unref(entry);
}

inline std::string BigEndian(std::initializer_list<unsigned> numbers) {
  std::string bytes;
  for (const unsigned number : numbers) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  }
  return bytes;
}

// Behind the start of the JPEG, as cameras have it.
inline std::string WithExif(const std::vector<std::byte>& jpeg, const ExifTags& tags) {
  ExifData* data = exif_data_new();
  exif_data_set_byte_order(data, EXIF_BYTE_ORDER_MOTOROLA);
  const auto add_text = [&](ExifTag tag, const std::string& text) {
    if (text.empty()) return;
    AddEntry(data, tag, EXIF_FORMAT_ASCII, static_cast<unsigned>(text.size() + 1), text + '\0');
  };
  add_text(EXIF_TAG_DATE_TIME_ORIGINAL, tags.time);
  add_text(EXIF_TAG_SUB_SEC_TIME_ORIGINAL, tags.decimals);
  add_text(EXIF_TAG_OFFSET_TIME_ORIGINAL, tags.offset);
  if (tags.has_exposure) {
    AddEntry(data, EXIF_TAG_EXPOSURE_TIME, EXIF_FORMAT_RATIONAL, 1, BigEndian({1, 250}));
    AddEntry(data, EXIF_TAG_FNUMBER, EXIF_FORMAT_RATIONAL, 1, BigEndian({28, 10}));
    AddEntry(data, EXIF_TAG_ISO_SPEED_RATINGS, EXIF_FORMAT_SHORT, 1, std::string("\0\xc8", 2));
  }
  unsigned char* blob = nullptr;
  unsigned size = 0;
  exif_data_save_data(data, &blob, &size);
  exif_data_unref(data);
  std::string file(reinterpret_cast<const char*>(jpeg.data()), 2);
  file += "\xff\xe1";
  file += static_cast<char>((size + 2) >> 8);
  file += static_cast<char>((size + 2) & 0xff);
  file.append(reinterpret_cast<const char*>(blob), size);
  std::free(blob);
  file.append(reinterpret_cast<const char*>(jpeg.data()) + 2, jpeg.size() - 2);
  return file;
}

}  // namespace pleinair::made_pictures
