#include "calib/exif_time.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <memory>

#include <libexif/exif-data.h>

namespace pleinair {
namespace {

std::string TextOf(const ExifData& data, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(data.ifd[EXIF_IFD_EXIF], tag);
  if (entry == nullptr || entry->format != EXIF_FORMAT_ASCII || entry->data == nullptr) return {};
  const auto* text = reinterpret_cast<const char*>(entry->data);
  std::string found(text, strnlen(text, entry->size));
  found.erase(found.find_last_not_of(' ') + 1);
  return found;
}

// Whether the text is as `form`, where 0 is any digit.
bool HasForm(const std::string& text, const std::string& form) {
  return std::ranges::equal(text, form, [](char c, char f) {
    return f == '0' ? std::isdigit(static_cast<unsigned char>(c)) != 0 : c == f;
  });
}

}  // namespace

std::optional<ExifTime> ReadExifTime(const std::filesystem::path& file) {
  const std::unique_ptr<ExifData, decltype(&exif_data_unref)> data(
      exif_data_new_from_file(file.c_str()), &exif_data_unref);
  if (!data) return std::nullopt;
  ExifTime time;
  time.local_time = TextOf(*data, EXIF_TAG_DATE_TIME_ORIGINAL);
  if (!HasForm(time.local_time, "0000:00:00 00:00:00")) return std::nullopt;
  time.local_time[4] = time.local_time[7] = '-';
  time.local_time[10] = 'T';
  constexpr std::size_t kMostDecimals = 9;
  std::string decimals = TextOf(*data, EXIF_TAG_SUB_SEC_TIME_ORIGINAL).substr(0, kMostDecimals);
  if (!decimals.empty() && HasForm(decimals, std::string(decimals.size(), '0'))) {
    time.local_time += "." + decimals;
  }
  const std::string offset = TextOf(*data, EXIF_TAG_OFFSET_TIME_ORIGINAL);
  if (offset == "Z" || HasForm(offset, "+00:00") || HasForm(offset, "-00:00")) {
    time.utc_offset = offset;
  }
  return time;
}

}  // namespace pleinair
