// `pleinair calibrate`: camera files from pictures of charts, brackets, marks and the sun.
// Each function writes its file, completely or not at all, and returns the report to print.
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
  std::string corners;             // Of the chart, "x,y" four times; empty: found.
  std::string curve = "monotone";  // For the chart: monotone or logarithmic.
  std::filesystem::path out;
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
  std::filesystem::path pairs;  // CSV: fish-eye r,g,b, room r,g,b. Or a chart seen by both:
  std::filesystem::path fisheye_picture;
  std::filesystem::path room_picture;
  std::string fisheye_corners;  // Empty: found.
  std::string room_corners;
  std::string fisheye_response = "srgb8";  // For 8-bit pictures.
  std::string room_response = "srgb8";
  bool matrix = false;
  std::filesystem::path calibration;  // The fish-eye's file, read and written.
  std::filesystem::path out;          // Not given: the same.
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
  std::filesystem::path out;  // Not given: the same as `calibration`.
};
std::string RunCalibrateOrientation(const CalibrateOrientationOptions& options);

}  // namespace pleinair
