#include "calib/exif_lens.h"

#include <memory>

#include <libexif/exif-data.h>

namespace pleinair {

std::optional<double> ReadExifFocalLength35mm(const std::filesystem::path& file) {
  const std::unique_ptr<ExifData, decltype(&exif_data_unref)> data(
      exif_data_new_from_file(file.c_str()), &exif_data_unref);
  if (!data) return std::nullopt;
  const ExifEntry* entry =
      exif_content_get_entry(data->ifd[EXIF_IFD_EXIF], EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM);
  if (entry == nullptr || entry->format != EXIF_FORMAT_SHORT || entry->size < 2) {
    return std::nullopt;
  }
  const int millimetres = exif_get_short(entry->data, exif_data_get_byte_order(data.get()));
  if (millimetres == 0) return std::nullopt;  // Unknown, by the standard.
  return millimetres;
}

}  // namespace pleinair
