#include "calib/exif_place.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include <libexif/exif-data.h>

namespace pleinair {
namespace {

class Tags {
 public:
  explicit Tags(ExifData& data) : data_(data) {}

  // Number `index` of a tag's rationals.
  std::optional<double> Rational(ExifIfd ifd, int tag, unsigned index = 0) const {
    const ExifEntry* entry = Find(ifd, tag);
    if (entry == nullptr || entry->format != EXIF_FORMAT_RATIONAL || entry->components <= index ||
        entry->size < 8 * (index + 1)) {
      return std::nullopt;
    }
    const ExifRational ratio =
        exif_get_rational(entry->data + 8 * index, exif_data_get_byte_order(&data_));
    if (ratio.denominator == 0) return std::nullopt;
    return static_cast<double>(ratio.numerator) / static_cast<double>(ratio.denominator);
  }
  std::optional<int> Integer(ExifIfd ifd, int tag) const {
    const ExifEntry* entry = Find(ifd, tag);
    if (entry == nullptr || entry->components < 1) return std::nullopt;
    if (entry->format == EXIF_FORMAT_BYTE && entry->size >= 1) return entry->data[0];
    if (entry->format == EXIF_FORMAT_SHORT && entry->size >= 2) {
      return exif_get_short(entry->data, exif_data_get_byte_order(&data_));
    }
    return std::nullopt;
  }
  std::string Text(ExifIfd ifd, int tag) const {
    const ExifEntry* entry = Find(ifd, tag);
    if (entry == nullptr || entry->format != EXIF_FORMAT_ASCII || entry->data == nullptr) return {};
    const auto* text = reinterpret_cast<const char*>(entry->data);
    return {text, strnlen(text, entry->size)};
  }

 private:
  const ExifEntry* Find(ExifIfd ifd, int tag) const {
    const ExifEntry* entry = exif_content_get_entry(data_.ifd[ifd], static_cast<ExifTag>(tag));
    return entry != nullptr && entry->data != nullptr ? entry : nullptr;
  }

  ExifData& data_;
};

// Degrees, minutes and seconds, with a letter for the negative half.
std::optional<double> Angle(const Tags& tags, int tag, int letter_tag, char negative, double most) {
  const auto degrees = tags.Rational(EXIF_IFD_GPS, tag, 0);
  if (!degrees) return std::nullopt;
  const double angle = *degrees + tags.Rational(EXIF_IFD_GPS, tag, 1).value_or(0.0) / 60.0 +
                       tags.Rational(EXIF_IFD_GPS, tag, 2).value_or(0.0) / 3600.0;
  const std::string letter = tags.Text(EXIF_IFD_GPS, letter_tag);
  if (letter.empty() || !(angle <= most)) return std::nullopt;
  return letter[0] == negative ? -angle : angle;
}

std::string UtcOf(const Tags& tags) {
  const std::string date = tags.Text(EXIF_IFD_GPS, EXIF_TAG_GPS_DATE_STAMP);
  const auto hour = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 0);
  const auto minute = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 1);
  const auto second = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 2);
  if (date.size() != 10 || date[4] != ':' || date[7] != ':' || !hour || !minute || !second) {
    return {};
  }
  for (const int i : {0, 1, 2, 3, 5, 6, 8, 9}) {
    if (std::isdigit(static_cast<unsigned char>(date[i])) == 0) return {};
  }
  if (!(*hour < 24.0 && *minute < 60.0 && *second < 60.0)) return {};
  char text[40];
  std::snprintf(text,
                sizeof(text),
                "%.4s-%.2s-%.2sT%02d:%02d:%06.3fZ",
                date.c_str(),
                date.c_str() + 5,
                date.c_str() + 8,
                static_cast<int>(*hour),
                static_cast<int>(*minute),
                std::min(*second, 59.999));
  return text;
}

}  // namespace

ExifPlace ReadExifPlace(const std::filesystem::path& file) {
  const std::unique_ptr<ExifData, decltype(&exif_data_unref)> data(
      exif_data_new_from_file(file.c_str()), &exif_data_unref);
  ExifPlace place;
  if (!data) return place;
  const Tags tags(*data);
  const auto latitude = Angle(tags, EXIF_TAG_GPS_LATITUDE, EXIF_TAG_GPS_LATITUDE_REF, 'S', 90.0);
  const auto longitude =
      Angle(tags, EXIF_TAG_GPS_LONGITUDE, EXIF_TAG_GPS_LONGITUDE_REF, 'W', 180.0);
  // Receivers without a fix write zeros.
  if (latitude && longitude && (*latitude != 0.0 || *longitude != 0.0)) {
    place.latitude_deg = latitude;
    place.longitude_deg = longitude;
    if (auto altitude = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE)) {
      const bool is_below = tags.Integer(EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE_REF) == 1;
      if (*altitude <= 1e5) place.altitude_m = is_below ? -*altitude : *altitude;
    }
    const auto sigma = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_H_POSITIONING_ERROR);
    if (sigma && *sigma > 0.0) place.position_sigma_m = sigma;
  }
  // A heading from magnetic north needs the declination: left out.
  const auto heading = tags.Rational(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION);
  if (heading && *heading <= 360.0 &&
      tags.Text(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION_REF).starts_with('T')) {
    place.heading_deg = heading;
  }
  place.utc = UtcOf(tags);
  const auto orientation = tags.Integer(EXIF_IFD_0, EXIF_TAG_ORIENTATION);
  if (orientation && *orientation >= 1 && *orientation <= 8) place.orientation = *orientation;
  return place;
}

}  // namespace pleinair
