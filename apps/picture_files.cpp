#include "apps/picture_files.h"

#include <algorithm>
#include <stdexcept>

#include "apps/number_table.h"
#include "calib/exif_exposure.h"
#include "scene/image_io.h"

namespace pleinair {

void RequireHdrName(const std::filesystem::path& file) {
  if (file.extension() == ".exr" || file.extension() == ".hdr") return;
  throw std::invalid_argument("--out " + file.string() + ": expected a name in .exr or .hdr");
}

void WriteRadiance(const std::filesystem::path& file, const RgbImage& radiance) {
  file.extension() == ".exr" ? WriteExr(file, radiance, ExrPrecision::kFloat)
                             : WriteHdr(file, radiance);
}

ResponseCurve ResponseFrom(const std::string& name) {
  return name == "srgb8" ? ResponseCurve::Srgb() : ResponseCurve::FromFile(name);
}

std::vector<double> ExposuresOf(const std::vector<std::filesystem::path>& pictures,
                                const std::vector<double>& stated) {
  if (!stated.empty()) {
    if (stated.size() == pictures.size()) return stated;
    throw std::invalid_argument("--exposures: expected one a picture, " +
                                std::to_string(pictures.size()) + ", found " +
                                std::to_string(stated.size()));
  }
  std::vector<double> exposures;
  for (const std::filesystem::path& picture : pictures) {
    if (!std::filesystem::exists(picture)) {
      throw std::invalid_argument(picture.string() + ": expected a picture, found nothing");
    }
    const auto exposure = ReadExifExposure(picture).RelativeExposure();
    if (!exposure) {
      throw std::invalid_argument(picture.string() +
                                  ": expected an exposure time in its EXIF data, or --exposures");
    }
    exposures.push_back(*exposure);
  }
  return exposures;
}

std::vector<ExposedPicture> ReadBracket(const std::vector<std::filesystem::path>& files,
                                        const std::vector<double>& stated_exposures) {
  const std::vector<double> exposures = ExposuresOf(files, stated_exposures);
  std::vector<ExposedPicture> pictures;
  for (std::size_t i = 0; i < files.size(); ++i) {
    pictures.push_back({ReadDisplayImage(files[i]), exposures[i]});
  }
  return pictures;
}

ChartCorners ChartIn(const Rgb8Image& picture,
                     const std::string& corners,
                     const std::filesystem::path& file) {
  if (corners.empty()) {
    const auto found = FindColourChart(picture);
    if (found) return *found;
    throw std::runtime_error(
        file.string() + ": expected a ColorChecker of 24 patches, found none: give its corners");
  }
  const std::vector<double> numbers = ParseNumbers(corners, "corners");
  if (numbers.size() != 8) {
    throw std::invalid_argument("corners " + corners +
                                ": expected x,y of the outer corners of dark "
                                "skin, bluish green, black and white: 8 numbers");
  }
  ChartCorners chart;
  for (std::size_t i = 0; i < 4; ++i) chart[i] = {numbers[2 * i], numbers[2 * i + 1]};
  return chart;
}

RgbImage ReadLinear(const std::filesystem::path& file, const std::string& response) {
  if (HoldsRadiance(file)) return ReadRadianceImage(file);
  return RadianceFromCodes(ReadDisplayImage(file), ResponseFrom(response), 1.0);
}

}  // namespace pleinair
