// `pleinair calibrate`: camera files from pictures of charts, brackets, marks and the sun.
// Each function writes its file, completely or not at all, and returns the report to print. Those
// with `force` throw std::runtime_error where the result is not credible and it is false.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pleinair {

struct CalibrateResponseOptions {
  std::vector<std::filesystem::path> pictures;
  std::vector<double> exposures;   // One a picture; empty: from EXIF.
  bool chart = false;              // From a ColorChecker in each picture, not from the bracket.
  std::string corners;             // Corners of the chart, "x,y" four times; empty: found.
  std::string curve = "monotone";  // For the chart: monotone or logarithmic.
  // At least one of these two.
  std::filesystem::path out;
  std::filesystem::path site;  // The folder whose camera it is.
  bool force = false;          // Write a bracket's curve that is in doubt, too.
};
std::string RunCalibrateResponse(const CalibrateResponseOptions& options);

struct CalibrateMergeOptions {
  std::vector<std::filesystem::path> pictures;
  std::vector<double> exposures;  // As above.
  std::string response = "srgb8";
  std::filesystem::path out;  // .exr or .hdr
};
// One HDR picture from an exposure bracket.
std::string RunCalibrateMerge(const CalibrateMergeOptions& options);

struct CalibrateAverageOptions {
  std::vector<std::filesystem::path> frames;
  std::filesystem::path out;  // .exr or .hdr
};
// The mean of HDR frames of a camera that stands still.
std::string RunCalibrateAverage(const CalibrateAverageOptions& options);

struct CalibrateColourOptions {
  std::filesystem::path pairs;  // CSV: this camera's r,g,b, the other's r,g,b. Or pictures:
  std::filesystem::path from_picture;
  std::filesystem::path to_picture;
  // CSV: x, y, radius (pixels) in each picture, or without to_picture x, y, radius, r, g, b. Empty:
  // a chart is seen in both.
  std::filesystem::path regions;
  std::string from_corners;  // Corners of the chart; empty: found.
  std::string to_corners;
  std::string from_response;  // For 8-bit pictures; empty: the site's, or srgb8.
  std::string to_response = "srgb8";
  bool matrix = false;
  bool force = false;  // Write factors of pairs that contradict each other, too.
  // The camera: a fish-eye's file, or a site's folder or file. Read and written.
  std::filesystem::path calibration;
  std::filesystem::path out;  // Not given: the same.
};
std::string RunCalibrateColour(const CalibrateColourOptions& options);

struct CalibrateOrientationOptions {
  std::filesystem::path calibration;  // The fish-eye's file, read and written.
  std::filesystem::path marks;        // CSV: x, y (pixels), east, north, up.
  std::vector<std::filesystem::path> sun_pictures;
  std::vector<std::string> times;  // One a sun picture.
  std::string site;
  bool levelled = false;  // The optical axis is the zenith: one sun or mark gives north.
  bool mirrored = false;
  bool force = false;         // Write an orientation that is in doubt, too.
  std::filesystem::path out;  // Not given: the same as `calibration`.
};
std::string RunCalibrateOrientation(const CalibrateOrientationOptions& options);

}  // namespace pleinair
