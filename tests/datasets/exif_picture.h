// JPEGs with EXIF data.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <libexif/exif-data.h>

namespace pleinair {

struct ExifValue {
  ExifIfd ifd;
  int tag;
  ExifFormat format;
  unsigned count;
  std::string bytes;  // Big-endian.
};

inline ExifValue ExifText(ExifIfd ifd, int tag, const std::string& text) {
  return {ifd, tag, EXIF_FORMAT_ASCII, static_cast<unsigned>(text.size() + 1), text + '\0'};
}

inline std::string BigEndian(const std::vector<unsigned>& numbers) {
  std::string bytes;
  for (const unsigned number : numbers) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  }
  return bytes;
}

// Numerators and denominators.
inline ExifValue ExifRationals(ExifIfd ifd, int tag, const std::vector<unsigned>& numbers) {
  return {ifd,
          tag,
          EXIF_FORMAT_RATIONAL,
          static_cast<unsigned>(numbers.size() / 2),
          BigEndian(numbers)};
}

inline ExifValue ExifShort(ExifIfd ifd, int tag, unsigned value) {
  return {ifd,
          tag,
          EXIF_FORMAT_SHORT,
          1,
          std::string{static_cast<char>(value >> 8U), static_cast<char>(value)}};
}

// The data stand behind the start of the JPEG, as cameras have it.
inline std::string WithExif(const std::vector<std::byte>& jpeg,
                            const std::vector<ExifValue>& values) {
  ExifData* data = exif_data_new();
  exif_data_set_byte_order(data, EXIF_BYTE_ORDER_MOTOROLA);
  for (const ExifValue& value : values) {
    ExifEntry* entry = exif_entry_new();
    entry->tag = static_cast<ExifTag>(value.tag);
    entry->format = value.format;
    entry->components = value.count;
    entry->size = static_cast<unsigned>(value.bytes.size());
    entry->data = static_cast<unsigned char*>(std::malloc(value.bytes.size()));
    std::memcpy(entry->data, value.bytes.data(), value.bytes.size());
    exif_content_add_entry(data->ifd[value.ifd], entry);
    exif_entry_unref(entry);
  }
  unsigned char* blob = nullptr;
  unsigned size = 0;
  exif_data_save_data(data, &blob, &size);
  exif_data_unref(data);
  std::string file(reinterpret_cast<const char*>(jpeg.data()), 2);
  file += "\xff\xe1";
  file += static_cast<char>((size + 2) >> 8U);
  file += static_cast<char>((size + 2) & 0xffU);
  file.append(reinterpret_cast<const char*>(blob), size);
  std::free(blob);
  file.append(reinterpret_cast<const char*>(jpeg.data()) + 2, jpeg.size() - 2);
  return file;
}

// What most cameras write.
struct ExifTags {
  std::string time;  // "2026:06:21 12:00:00"
  std::string decimals;
  std::string offset;
  bool has_exposure = false;  // 1/250 s, f/2.8, ISO 200.
  unsigned orientation = 0;   // 0: not stated.
};

inline std::string WithExif(const std::vector<std::byte>& jpeg, const ExifTags& tags) {
  std::vector<ExifValue> values;
  const auto add_text = [&](ExifTag tag, const std::string& text) {
    if (!text.empty()) values.push_back(ExifText(EXIF_IFD_EXIF, tag, text));
  };
  add_text(EXIF_TAG_DATE_TIME_ORIGINAL, tags.time);
  add_text(EXIF_TAG_SUB_SEC_TIME_ORIGINAL, tags.decimals);
  add_text(EXIF_TAG_OFFSET_TIME_ORIGINAL, tags.offset);
  if (tags.has_exposure) {
    values.push_back(ExifRationals(EXIF_IFD_EXIF, EXIF_TAG_EXPOSURE_TIME, {1, 250}));
    values.push_back(ExifRationals(EXIF_IFD_EXIF, EXIF_TAG_FNUMBER, {28, 10}));
    values.push_back(ExifShort(EXIF_IFD_EXIF, EXIF_TAG_ISO_SPEED_RATINGS, 200));
  }
  if (tags.orientation != 0) {
    values.push_back(ExifShort(EXIF_IFD_0, EXIF_TAG_ORIENTATION, tags.orientation));
  }
  return WithExif(jpeg, values);
}

}  // namespace pleinair
