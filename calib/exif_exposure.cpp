#include "calib/exif_exposure.h"

#include <cmath>
#include <memory>

#include <libexif/exif-data.h>

namespace pleinair {
namespace {

std::optional<double> PositiveValue(const ExifData& data, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(data.ifd[EXIF_IFD_EXIF], tag);
  if (entry == nullptr || entry->components < 1) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(const_cast<ExifData*>(&data));
  double value = 0.0;
  if (entry->format == EXIF_FORMAT_RATIONAL && entry->size >= 8) {
    const ExifRational ratio = exif_get_rational(entry->data, order);
    value = static_cast<double>(ratio.numerator) / static_cast<double>(ratio.denominator);
  } else if (entry->format == EXIF_FORMAT_SHORT && entry->size >= 2) {
    value = exif_get_short(entry->data, order);
  } else if (entry->format == EXIF_FORMAT_LONG && entry->size >= 4) {
    value = static_cast<double>(exif_get_long(entry->data, order));
  }
  if (!(value > 0.0) || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> ExifExposure::RelativeExposure() const {
  if (!exposure_s) return std::nullopt;
  const double n = f_number.value_or(1.0);
  return *exposure_s * iso.value_or(1.0) / (n * n);
}

ExifExposure ReadExifExposure(const std::filesystem::path& file) {
  const std::unique_ptr<ExifData, decltype(&exif_data_unref)> data(
      exif_data_new_from_file(file.c_str()), &exif_data_unref);
  ExifExposure exposure;
  if (!data) return exposure;
  exposure.exposure_s = PositiveValue(*data, EXIF_TAG_EXPOSURE_TIME);
  exposure.iso = PositiveValue(*data, EXIF_TAG_ISO_SPEED_RATINGS);
  exposure.f_number = PositiveValue(*data, EXIF_TAG_FNUMBER);
  return exposure;
}

}  // namespace pleinair
