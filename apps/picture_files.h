// Pictures as calibration takes them: with exposure, as light, with a chart in them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/colour_chart.h"
#include "calib/exposure_merge.h"
#include "calib/response.h"
#include "scene/image.h"

namespace pleinair {

// Before the work whose result cannot be written under that name: EXR or Radiance HDR, by its
// ending. Throws std::invalid_argument.
void RequireHdrName(const std::filesystem::path& file);
void WriteRadiance(const std::filesystem::path& file, const RgbImage& radiance);

// "srgb8", or a response file's name. Throws as ResponseCurve::FromFile.
ResponseCurve ResponseFrom(const std::string& name);

// One exposure a picture: those stated, or where none are the EXIF data's. Throws
// std::invalid_argument where they do not go with the pictures.
std::vector<double> ExposuresOf(const std::vector<std::filesystem::path>& pictures,
                                const std::vector<double>& stated);
std::vector<ExposedPicture> ReadBracket(const std::vector<std::filesystem::path>& files,
                                        const std::vector<double>& stated_exposures);

// The chart at `corners` ("x,y" four times), or where they are empty where it is found. Throws
// naming the file, or the corners.
ChartCorners ChartIn(const Rgb8Image& picture,
                     const std::string& corners,
                     const std::filesystem::path& file);

// A picture as light, whatever its file: an 8-bit one by its response, in [0, 1].
RgbImage ReadLinear(const std::filesystem::path& file, const std::string& response);

}  // namespace pleinair
