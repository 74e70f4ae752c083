#include "datasets/reconstruction/internal/photograph.h"

#include <cstdint>
#include <ratio>
#include <stdexcept>

#include "calib/exif_time.h"
#include "datasets/internal/sequence_folder.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

std::optional<UtcTime> Parsed(const std::string& text) {
  if (text.empty()) return std::nullopt;
  try {
    return ParseUtcTime(text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<UtcTime> TimeOf(const std::filesystem::path& file,
                              const ExifPlace& place,
                              std::optional<std::chrono::minutes> utc_offset) {
  const auto exif = ReadExifTime(file);
  const std::optional<UtcTime> received = Parsed(place.utc);
  if (!exif) return received;
  if (!exif->utc_offset.empty()) return Parsed(exif->local_time + exif->utc_offset);
  const std::optional<UtcTime> local = Parsed(exif->local_time + "Z");
  if (!local) return received;
  if (utc_offset) return *local - *utc_offset;
  if (!received) return std::nullopt;
  // Zones are quarters of an hour; the camera's clock may be minutes off, and the receiver's last
  // fix older than the picture.
  using Quarters = std::chrono::duration<std::int64_t, std::ratio<900>>;
  constexpr std::chrono::minutes kClockError{5};
  using std::chrono::seconds;
  const seconds ahead = std::chrono::floor<seconds>(*local).time_since_epoch() -
                        std::chrono::floor<seconds>(*received).time_since_epoch();
  const auto zone = std::chrono::round<Quarters>(ahead);
  if (std::chrono::abs(ahead - zone) > kClockError) return received;
  return *local - zone;
}

std::optional<Photograph> FindPhotograph(const std::filesystem::path& folder,
                                         const std::string& name,
                                         std::optional<std::chrono::minutes> utc_offset) {
  const auto inside = ResolveInside(folder, name);
  if (!inside) return std::nullopt;
  Photograph photograph;
  photograph.file = *inside;
  std::error_code error;
  if (!std::filesystem::is_regular_file(photograph.file, error)) return std::nullopt;
  photograph.place = ReadExifPlace(photograph.file);
  photograph.exposure = ReadExifExposure(photograph.file);
  photograph.time = TimeOf(photograph.file, photograph.place, utc_offset);
  return photograph;
}

}  // namespace pleinair
