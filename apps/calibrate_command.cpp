#include "apps/calibrate_command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <stdexcept>

#include <glm/geometric.hpp>

#include "apps/chart_greys.h"
#include "apps/number_table.h"
#include "apps/picture_files.h"
#include "apps/site_response.h"
#include "calib/bracket_fit.h"
#include "calib/colour_chart.h"
#include "calib/colour_tie.h"
#include "calib/exposure_merge.h"
#include "calib/fisheye_file.h"
#include "calib/fisheye_orientation.h"
#include "calib/frame_average.h"
#include "calib/json_cursor.h"
#include "calib/response_fit.h"
#include "calib/shown_picture.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

[[gnu::format(printf, 1, 2)]] std::string Line(const char* format, ...) {
  std::array<char, 512> text{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return std::string(text.data()) + "\n";
}

std::string Report(const ResponseFit& fit) {
  std::string text;
  constexpr std::array<const char*, 3> kNames{"red", "green", "blue"};
  for (std::size_t c = 0; c < 3; ++c) {
    const ResponseChannelFit& channel = fit.channels[c];
    text += Line("%-6s codes %d to %d seen, rms %.1f %% of the light%s",
                 kNames[c],
                 channel.lowest_code,
                 channel.highest_code,
                 100.0 * channel.rms_relative,
                 channel.falls_repaired > 0 ? ", falling parts made to rise" : "");
  }
  return text;
}

// A line for an unusable picture.
std::string LeftOut(const std::filesystem::path& file, const std::string& message) {
  const std::string name = file.string() + ": ";
  return name + "left out: " + (message.starts_with(name) ? message.substr(name.size()) : message) +
         "\n";
}

// Refuses a result that is not credible, or returns the line of a report that it was forced.
std::string RefuseUnlessForced(const std::string& doubt, bool force) {
  if (doubt.empty()) return {};
  if (!force) throw std::runtime_error(doubt + "; --force writes it all the same");
  return "forced: " + doubt + "\n";
}

std::string Describe(const std::filesystem::path& file, const BracketPicture& picture) {
  if (!picture.reason.empty()) return LeftOut(file, picture.reason);
  if (!picture.is_compared) return file.string() + ": not compared: too few pictures\n";
  return Line("%s: light off by %+.1f %%, scatters by %.1f %%",
              file.c_str(),
              100.0 * std::expm1(picture.offset),
              100.0 * picture.scatter);
}

// The bracket without unusable pictures, which the report names.
ResponseFit FitReadableBracket(const CalibrateResponseOptions& options, std::string& report) {
  if (!options.exposures.empty()) ExposuresOf(options.pictures, options.exposures);  // One each.
  std::vector<ExposedPicture> pictures;
  std::vector<std::filesystem::path> files;
  std::string first_reason;
  for (std::size_t i = 0; i < options.pictures.size(); ++i) {
    const std::filesystem::path& file = options.pictures[i];
    try {
      const double exposure =
          options.exposures.empty() ? ExposuresOf({file}, {})[0] : options.exposures[i];
      pictures.push_back({ReadDisplayImage(file), exposure});
      const Rgb8Image& first = pictures.front().codes;
      const Rgb8Image& codes = pictures.back().codes;
      if (codes.width != first.width || codes.height != first.height) {
        pictures.pop_back();
        throw std::runtime_error("expected the size of the first");
      }
      files.push_back(file);
    } catch (const std::exception& error) {
      report += LeftOut(file, error.what());
      if (first_reason.empty()) first_reason = error.what();
    }
  }
  if (pictures.size() < 2 && !first_reason.empty()) throw std::runtime_error(first_reason);
  const BracketFit fit = FitBracket(pictures);
  for (std::size_t i = 0; i < files.size(); ++i) report += Describe(files[i], fit.pictures[i]);
  std::string doubt = DoubtAbout(fit.response);
  if (!doubt.empty()) doubt += ": expected one view from a fixed camera, and the exposures of each";
  report += RefuseUnlessForced(doubt, options.force);
  return fit.response;
}

// The greys of the charts, where they are neither clipped nor lost in noise.
std::array<std::vector<ResponseSample>, 3> ChartSamples(const CalibrateResponseOptions& options,
                                                        std::string& report) {
  std::array<std::vector<ResponseSample>, 3> samples;
  std::vector<double> exposures(options.pictures.size(), 1.0);
  if (options.pictures.size() > 1) exposures = ExposuresOf(options.pictures, options.exposures);
  for (std::size_t i = 0; i < options.pictures.size(); ++i) {
    std::array<ChartPatch, kChartPatches> patches;
    try {
      const Rgb8Image picture = ReadDisplayImage(options.pictures[i]);
      patches = MeasureChart(picture, ChartIn(picture, options.corners, options.pictures[i]));
    } catch (const std::runtime_error& error) {
      if (options.pictures.size() == 1) throw;
      report += LeftOut(options.pictures[i], error.what());
      continue;
    }
    AddGreys(patches, exposures[i], samples);
  }
  return samples;
}

std::array<ChartPatch, kChartPatches> ChartColours(const std::filesystem::path& file,
                                                   const std::string& corners,
                                                   const std::string& response) {
  const RgbImage radiance = ReadLinear(file, response);
  return MeasureChart(radiance, ChartIn(Shown(radiance), corners, file));
}

std::vector<ColourPair> ColourPairs(const CalibrateColourOptions& options,
                                    const std::string& from_response) {
  std::vector<ColourPair> pairs;
  if (!options.pairs.empty()) {
    for (const std::vector<double>& row : ReadNumberTable(options.pairs, 6)) {
      pairs.push_back({{row[0], row[1], row[2]}, {row[3], row[4], row[5]}});
    }
    return pairs;
  }
  if (options.from_picture.empty()) {
    throw std::invalid_argument("expected --pairs, or pictures of this camera and the other");
  }
  if (!options.regions.empty()) {
    const RgbImage from = ReadLinear(options.from_picture, from_response);
    RgbImage to;
    if (!options.to_picture.empty()) to = ReadLinear(options.to_picture, options.to_response);
    for (const std::vector<double>& row : ReadNumberTable(options.regions, 6)) {
      const glm::dvec3 second(row[3], row[4], row[5]);
      pairs.push_back({MeanOfDisc(from, {row[0], row[1]}, row[2]),
                       to.Empty() ? second : MeanOfDisc(to, {row[3], row[4]}, row[5])});
    }
    return pairs;
  }
  const auto from = ChartColours(options.from_picture, options.from_corners, from_response);
  const auto to = ChartColours(options.to_picture, options.to_corners, options.to_response);
  for (std::size_t i = 0; i < kChartPatches; ++i) pairs.push_back({from[i].mean, to[i].mean});
  return pairs;
}

std::string DescribeTie(const ColourTie& tie) {
  std::string report;
  for (int row = 0; row < 3; ++row) {
    report += Line("%10.5f %10.5f %10.5f",
                   tie.to_from_rgb[0][row],
                   tie.to_from_rgb[1][row],
                   tie.to_from_rgb[2][row]);
  }
  for (std::size_t i = 0; i < tie.counts.size(); ++i) {
    report += Line("pair %zu: off by %.1f %%%s",
                   i + 1,
                   100.0 * tie.residual_relative[i],
                   tie.counts[i] ? "" : ", left out");
  }
  return report + Line("rms %.2f %% over %td pairs",
                       100.0 * tie.rms_relative,
                       std::count(tie.counts.begin(), tie.counts.end(), true));
}

// A site's camera: its response takes the factors.
std::string TieSite(const CalibrateColourOptions& options, const std::filesystem::path& file) {
  if (options.matrix) {
    throw std::invalid_argument(
        "--matrix: expected a fish-eye's file, as a site's camera has a "
        "factor for each channel only");
  }
  const std::string response = ResponseNameIn(file);
  const ColourTie tie = FitColourTie(
      ColourPairs(options, options.from_response.empty() ? response : options.from_response),
      ColourTieKind::kScale);
  const std::string forced = RefuseUnlessForced(DoubtAbout(tie), options.force);
  const double largest = WriteTiedResponse(
      ResponseFrom(response), tie, file, options.out.empty() ? file : options.out);
  return DescribeTie(tie) + forced +
         Line("the camera's 1 is %.5g of the other's; its response is now %s",
              largest,
              kSiteResponseFile);
}

std::string Coordinate(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

struct NamedMark {
  std::string name;
  DirectionPair pair;
};

DirectionPair SunMark(const std::filesystem::path& file,
                      const std::string& time,
                      const Site& site,
                      const FisheyeLens& lens) {
  const RgbImage picture = ReadLinear(file, "srgb8");
  if (picture.width != lens.Intrinsics().width_px ||
      picture.height != lens.Intrinsics().height_px) {
    throw std::runtime_error(
        file.string() + ": expected " + std::to_string(lens.Intrinsics().width_px) + "x" +
        std::to_string(lens.Intrinsics().height_px) + " pixels, as the calibration says");
  }
  const auto sun = FindSunImage(picture, lens);
  if (!sun) {
    throw std::runtime_error(file.string() +
                             ": expected the sun's image: one small spot brighter than all else");
  }
  const glm::dvec3 direction = ApparentSunDirectionEnu(site, ParseUtcTime(time));
  if (!(direction.z > 0.0)) {
    throw std::runtime_error(file.string() + ": expected a time with the sun up, at " + time +
                             " it is below the site's horizon");
  }
  return {sun->direction_camera, direction};
}

std::vector<NamedMark> Marks(const CalibrateOrientationOptions& options, const FisheyeLens& lens) {
  std::vector<NamedMark> marks;
  if (!options.marks.empty()) {
    for (const std::vector<double>& row : ReadNumberTable(options.marks, 5)) {
      std::string name = "mark " + Coordinate(row[0]) + "," + Coordinate(row[1]);
      const auto direction = lens.DirectionFromPixel({row[0], row[1]});
      if (!direction) {
        throw std::runtime_error(options.marks.string() +
                                 ": expected pixels that the lens sees, found " + name);
      }
      marks.push_back({std::move(name), {*direction, {row[2], row[3], row[4]}}});
    }
  }
  if (options.sun_pictures.size() != options.times.size()) {
    throw std::invalid_argument("--time: expected one a sun picture, " +
                                std::to_string(options.sun_pictures.size()) + ", found " +
                                std::to_string(options.times.size()));
  }
  if (options.sun_pictures.empty()) return marks;
  const Site site = ParseSite(options.site);
  for (std::size_t i = 0; i < options.sun_pictures.size(); ++i) {
    marks.push_back({options.sun_pictures[i].string(),
                     SunMark(options.sun_pictures[i], options.times[i], site, lens)});
  }
  return marks;
}

// The noise of long brackets of small sensors makes up to 0.25, other views 0.5 and more.
constexpr double kMostDifference = 0.3;

}  // namespace

std::string RunCalibrateResponse(const CalibrateResponseOptions& options) {
  if (options.out.empty() && options.site.empty()) {
    throw std::invalid_argument("expected --out or --site, to write the response to");
  }
  ResponseFit fit;
  std::string report;
  if (!options.chart) {
    fit = FitReadableBracket(options, report);
  } else if (options.curve == "logarithmic") {
    const LogarithmicResponseFit logarithmic =
        FitLogarithmicResponse(ChartSamples(options, report));
    fit = logarithmic.response;
    for (const LogarithmicCurve& curve : logarithmic.curves) {
      report += Line("code = %.3f + %.3f ln(%.5g + light), rms %.2f codes",
                     curve.a,
                     curve.b,
                     curve.c,
                     curve.rms_codes);
    }
  } else {
    fit = FitMonotoneResponse(ChartSamples(options, report));
  }
  const std::string response = ResponseCurve::FromTable(fit.table).FileText();
  if (!options.out.empty()) WriteWholeText(options.out, response);
  if (!options.site.empty()) {
    const std::filesystem::path file = SiteFileIn(options.site);
    WriteSiteResponse(response, file, file);
  }
  return report + Report(fit);
}

std::string RunCalibrateMerge(const CalibrateMergeOptions& options) {
  RequireHdrName(options.out);
  const MergedExposures merged = MergeExposures(ReadBracket(options.pictures, options.exposures),
                                                ResponseFrom(options.response));
  WriteRadiance(options.out, merged.radiance);
  const auto count = [](const Gray8Image& flags) {
    return std::count(flags.pixels.begin(), flags.pixels.end(), std::uint8_t{1});
  };
  std::string report =
      Line("%zu pictures; clipped in all of them: %td pixels; at the noise floor: %td pixels",
           options.pictures.size(),
           count(merged.clipped),
           count(merged.at_noise_floor));
  if (merged.median_difference > kMostDifference) {
    report += Line(
        "warning: the pictures differ by %.0f %% (median) where they should agree: expected one "
        "view from a fixed camera, the pictures' own exposures, and their response",
        100.0 * merged.median_difference);
  }
  return report;
}

std::string RunCalibrateAverage(const CalibrateAverageOptions& options) {
  RequireHdrName(options.out);
  FrameAverage average;
  for (const std::filesystem::path& frame : options.frames) {
    try {
      average.Add(ReadRadianceImage(frame));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(frame.string() + ": " + error.what());
    }
  }
  const RgbImage mean = average.Mean();
  WriteRadiance(options.out, mean);
  const RgbImage error = average.StandardError();
  double light = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
    light += mean.pixels[i].y / static_cast<double>(mean.pixels.size());
    if (!std::isfinite(error.pixels[i].y)) continue;
    squares += error.pixels[i].y * error.pixels[i].y / static_cast<double>(mean.pixels.size());
  }
  std::string report = Line(
      "%d frames; standard error of the mean %.3g (rms, green) at mean %.3g; not finite: %lld "
      "pixels",
      average.FrameCount(),
      std::sqrt(squares),
      light,
      static_cast<long long>(average.LeftOutCount()));
  if (const double scatter = average.MedianScatter(); scatter > kMostDifference) {
    report += Line(
        "warning: the frames differ by %.0f %% (median) where they should agree: expected one view "
        "from a fixed camera, in one light",
        100.0 * scatter);
  }
  return report;
}

std::string RunCalibrateColour(const CalibrateColourOptions& options) {
  const std::filesystem::path file = SiteFileIn(options.calibration);
  const nlohmann::json document = LoadJson(file);
  if (document.is_object() && document.value("format", nlohmann::json()) != "pleinair-fisheye" &&
      document.contains("camera")) {
    return TieSite(options, file);
  }
  FisheyeCalibration calibration = ReadFisheyeCalibration(file);
  const ColourTie tie = FitColourTie(
      ColourPairs(options, options.from_response.empty() ? "srgb8" : options.from_response),
      options.matrix ? ColourTieKind::kMatrix : ColourTieKind::kScale);
  const std::string forced = RefuseUnlessForced(DoubtAbout(tie), options.force);
  calibration.room_from_fisheye_rgb = tie.to_from_rgb;
  WriteWholeText(options.out.empty() ? file : options.out, FisheyeCalibrationText(calibration));
  return DescribeTie(tie) + forced;
}

std::string RunCalibrateOrientation(const CalibrateOrientationOptions& options) {
  FisheyeCalibration calibration = ReadFisheyeCalibration(options.calibration);
  const std::vector<NamedMark> marks = Marks(options, FisheyeLens(calibration.intrinsics));
  if (marks.empty()) throw std::invalid_argument("expected --marks or --sun");
  const Handedness handedness = options.mirrored ? Handedness::kMirrored : Handedness::kRightHanded;
  OrientationFit fit;
  if (options.levelled) {
    if (marks.size() != 1) {
      throw std::invalid_argument("--levelled: expected one sun or mark, found " +
                                  std::to_string(marks.size()) + " (several need no level)");
    }
    fit = OrientationFromUp({0.0, 0.0, 1.0}, marks[0].pair, handedness);
  } else {
    if (marks.size() < 2) {
      throw std::invalid_argument("expected two suns or marks, or one and --levelled");
    }
    std::vector<DirectionPair> pairs;
    pairs.reserve(marks.size());
    for (const NamedMark& mark : marks) pairs.push_back(mark.pair);
    fit = FitOrientation(pairs, {handedness});
  }
  std::string doubt = DoubtAbout(fit);
  if (!doubt.empty()) {
    doubt += ": look at the order and signs of --site LAT,LON, the zone of --time, and --mirrored";
  }
  std::string report = RefuseUnlessForced(doubt, options.force);
  calibration.world_from_camera = fit.world_from_camera;
  WriteWholeText(options.out.empty() ? options.calibration : options.out,
                 FisheyeCalibrationText(calibration));

  for (std::size_t i = 0; i < marks.size(); ++i) {
    report += Line("%s: off by %.3f deg%s",
                   marks[i].name.c_str(),
                   DegFromRad(fit.residual_rad[i]),
                   fit.counts[i] ? "" : ", left out");
  }
  const glm::dvec3 up = -fit.world_from_camera[1];
  return report + Line(
                      "rms %.3f deg; the axis is %.2f deg from the zenith, the picture's up has "
                      "azimuth %.2f deg",
                      DegFromRad(fit.rms_rad),
                      DegFromRad(AxisFromZenithRad(fit)),
                      DegFromRad(std::atan2(up.x, up.y)) + (up.x < 0.0 ? 360.0 : 0.0));
}

}  // namespace pleinair
