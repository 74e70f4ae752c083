#include "apps/calibrate_command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "apps/number_table.h"
#include "apps/picture_files.h"
#include "apps/whole_text.h"
#include "calib/colour_chart.h"
#include "calib/colour_tie.h"
#include "calib/exposure_merge.h"
#include "calib/fisheye_file.h"
#include "calib/fisheye_fit.h"
#include "calib/fisheye_orientation.h"
#include "calib/frame_average.h"
#include "calib/response_fit.h"
#include "scene/image_io.h"
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

// The green channel, which most pixels of a sensor measure.
Gray8Image GreenOf(const Rgb8Image& picture) {
  Gray8Image green(picture.width, picture.height);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) green.pixels[i] = picture.pixels[i].y;
  return green;
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

// The greys of the charts, where they are neither clipped nor lost in noise.
std::array<std::vector<ResponseSample>, 3> ChartSamples(const CalibrateResponseOptions& options) {
  std::array<std::vector<ResponseSample>, 3> samples;
  std::vector<double> exposures(options.pictures.size(), 1.0);
  if (options.pictures.size() > 1) exposures = ExposuresOf(options.pictures, options.exposures);
  for (std::size_t i = 0; i < options.pictures.size(); ++i) {
    const Rgb8Image picture = ReadDisplayImage(options.pictures[i]);
    const auto patches =
        MeasureChart(picture, ChartIn(picture, options.corners, options.pictures[i]));
    for (const int grey : kChartGreys) {
      const auto index = static_cast<std::size_t>(grey);
      for (int c = 0; c < 3; ++c) {
        const double code = patches[index].mean[c];
        if (code >= kClippedFromCode - 1 || code <= kNoiseFloorUpToCode) continue;
        samples[static_cast<std::size_t>(c)].push_back(
            {exposures[i] * kChartReflectance[index], code});
      }
    }
  }
  return samples;
}

std::array<ChartPatch, kChartPatches> ChartColours(const std::filesystem::path& file,
                                                   const std::string& corners,
                                                   const std::string& response) {
  const RgbImage radiance = ReadLinear(file, response);
  return MeasureChart(radiance, ChartIn(Shown(radiance), corners, file));
}

std::vector<ColourPair> ColourPairs(const CalibrateColourOptions& options) {
  std::vector<ColourPair> pairs;
  if (!options.pairs.empty()) {
    for (const std::vector<double>& row : ReadNumberTable(options.pairs, 6)) {
      pairs.push_back({{row[0], row[1], row[2]}, {row[3], row[4], row[5]}});
    }
    return pairs;
  }
  const auto from =
      ChartColours(options.fisheye_picture, options.fisheye_corners, options.fisheye_response);
  const auto to = ChartColours(options.room_picture, options.room_corners, options.room_response);
  for (std::size_t i = 0; i < kChartPatches; ++i) pairs.push_back({from[i].mean, to[i].mean});
  return pairs;
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

BoardSize BoardSizeFrom(const std::string& text) {
  BoardSize board;
  int length = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &length) != 2 ||
      text.size() != static_cast<std::size_t>(length)) {
    throw std::invalid_argument("--board " + text +
                                ": expected columns and rows of inner corners, such as 8x6");
  }
  board.Validate();
  return board;
}

// What pictures say when they are taken to show a board of one size.
struct LensTrial {
  std::optional<FisheyeFit> fit;
  std::string doubt;                    // Why there is none, or it is not credible; or empty.
  std::vector<RejectedPicture> unread;  // And those in which there is no such board.
};

// `message` without the file that it begins with.
std::string WithoutFile(const std::string& message, const std::filesystem::path& file) {
  const std::string name = file.string() + ": ";
  return message.starts_with(name) ? message.substr(name.size()) : message;
}

// Throws std::runtime_error where not one of the files can be read.
LensTrial TryBoard(const std::vector<std::filesystem::path>& files, BoardSize board) {
  LensTrial trial;
  std::vector<BoardPicture> boards;
  int width = 0;
  int height = 0;
  for (const std::filesystem::path& file : files) {
    Gray8Image picture;
    try {
      picture = GreenOf(ReadDisplayImage(file));
    } catch (const std::exception& error) {
      trial.unread.push_back({file.string(), WithoutFile(error.what(), file)});
      continue;
    }
    if (width == 0) {
      width = picture.width;
      height = picture.height;
    }
    if (picture.width != width || picture.height != height) {
      trial.unread.push_back({file.string(),
                              std::to_string(picture.width) + "x" + std::to_string(picture.height) +
                                  " pixels where the first has " + std::to_string(width) + "x" +
                                  std::to_string(height)});
      continue;
    }
    const auto corners = FindBoardCorners(picture, board);
    if (!corners) {
      trial.unread.push_back(
          {file.string(), "no board of " + TextOf(board) + " inner corners found"});
      continue;
    }
    boards.push_back({file.string(), *corners});
  }
  if (width == 0 && !trial.unread.empty()) {
    throw std::runtime_error(trial.unread[0].name + ": " + trial.unread[0].reason +
                             ": expected pictures of a board");
  }
  if (boards.empty()) {
    trial.doubt = "expected pictures of a board of so many inner corners, found none";
    if (!trial.unread.empty()) {
      trial.doubt += "; " + trial.unread[0].name + ": " + trial.unread[0].reason;
    }
    return trial;
  }
  try {
    trial.fit = FitFisheyeLens(boards, board, width, height);
    trial.doubt = DoubtAbout(*trial.fit);
  } catch (const std::runtime_error& error) {
    trial.doubt = error.what();
  }
  return trial;
}

// Sizes of board that pictures show, but for `wrong`.
std::vector<BoardSize> SizesSeen(const std::vector<std::filesystem::path>& files, BoardSize wrong) {
  constexpr std::size_t kPicturesLookedAt = 12;
  std::vector<BoardSize> sizes;
  for (std::size_t i = 0; i < std::min(files.size(), kPicturesLookedAt); ++i) {
    std::optional<BoardSize> found;
    try {
      found = FindBoardSize(GreenOf(ReadDisplayImage(files[i])));
    } catch (const std::exception&) {
      continue;  // The trial of `wrong` has named it.
    }
    if (!found || *found == wrong || *found == BoardSize{wrong.rows, wrong.columns}) continue;
    if (std::find(sizes.begin(), sizes.end(), *found) == sizes.end()) sizes.push_back(*found);
  }
  return sizes;
}

// The size of board that the pictures fit, for a message. Parts of a board fit, too: of several
// sizes the one with most corners in all.
std::string AdviceOnBoard(const std::vector<std::filesystem::path>& files, BoardSize wrong) {
  std::string advice = "does not fit, nor does another size that is seen in the pictures";
  std::size_t most_corners = 0;
  for (const BoardSize size : SizesSeen(files, wrong)) {
    const LensTrial trial = TryBoard(files, size);
    if (!trial.fit || !trial.doubt.empty()) continue;
    const std::size_t corners = trial.fit->fitted.size() * static_cast<std::size_t>(size.Count());
    if (corners <= most_corners) continue;
    most_corners = corners;
    advice = fmt::format(
        "does not fit, --board {} does (rms {:.2f} px, fx {:.1f}, fy {:.1f}, {} pictures)",
        TextOf(size),
        trial.fit->rms_px,
        trial.fit->lens.fx_px,
        trial.fit->lens.fy_px,
        trial.fit->fitted.size());
  }
  return advice;
}

}  // namespace

std::string RunCalibrateFisheye(const CalibrateFisheyeOptions& options) {
  const BoardSize board = BoardSizeFrom(options.board);
  const LensTrial trial = TryBoard(options.pictures, board);
  if (!trial.doubt.empty() && !(options.force && trial.fit)) {
    throw std::runtime_error("--board " + TextOf(board) + " " +
                             AdviceOnBoard(options.pictures, board) + ": " + trial.doubt +
                             (trial.fit ? "; --force writes it all the same" : ""));
  }
  FisheyeFit fit = *trial.fit;
  if (options.fov_deg) fit.lens.max_angle_rad = 0.5 * RadFromDeg(*options.fov_deg);
  WriteWholeText(options.out, FisheyeCalibrationText({fit.lens, {}, {}, fit.rms_px}));

  const FisheyeIntrinsics& lens = fit.lens;
  std::string report;
  for (const FittedPicture& picture : fit.fitted) {
    report += Line("%s: rms %.2f px", picture.name.c_str(), picture.rms_px);
  }
  if (!trial.doubt.empty()) report += "forced: " + trial.doubt + "\n";
  for (const auto& rejected : {trial.unread, fit.rejected}) {
    for (const RejectedPicture& picture : rejected) {
      report += picture.name + ": left out: " + picture.reason + "\n";
    }
  }
  report += Line("fx %.2f fy %.2f cx %.2f cy %.2f px, k %.5f %.5f %.5f %.5f",
                 lens.fx_px,
                 lens.fy_px,
                 lens.cx_px,
                 lens.cy_px,
                 lens.distortion[0],
                 lens.distortion[1],
                 lens.distortion[2],
                 lens.distortion[3]);
  report +=
      Line("rms %.3f px over %zu pictures; boards reach %.1f deg from the axis, valid to %.1f",
           fit.rms_px,
           fit.fitted.size(),
           DegFromRad(fit.covered_angle_rad),
           DegFromRad(FisheyeLens(lens).MaxAngleRad()));
  return report;
}

std::string RunCalibrateResponse(const CalibrateResponseOptions& options) {
  ResponseFit fit;
  std::string report;
  if (!options.chart) {
    fit = FitResponseFromBrackets(ReadBracket(options.pictures, options.exposures));
  } else if (options.curve == "logarithmic") {
    const LogarithmicResponseFit logarithmic = FitLogarithmicResponse(ChartSamples(options));
    fit = logarithmic.response;
    for (const LogarithmicCurve& curve : logarithmic.curves) {
      report += Line("code = %.3f + %.3f ln(%.5g + light), rms %.2f codes",
                     curve.a,
                     curve.b,
                     curve.c,
                     curve.rms_codes);
    }
  } else {
    fit = FitMonotoneResponse(ChartSamples(options));
  }
  WriteWholeText(options.out, ResponseCurve::FromTable(fit.table).FileText());
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
  return Line("%zu pictures; clipped in all of them: %td pixels; at the noise floor: %td pixels",
              options.pictures.size(),
              count(merged.clipped),
              count(merged.at_noise_floor));
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
  return Line(
      "%d frames; standard error of the mean %.3g (rms, green) at mean %.3g; not finite: %lld "
      "pixels",
      average.FrameCount(),
      std::sqrt(squares),
      light,
      static_cast<long long>(average.LeftOutCount()));
}

std::string RunCalibrateColour(const CalibrateColourOptions& options) {
  FisheyeCalibration calibration = ReadFisheyeCalibration(options.calibration);
  const ColourTie tie = FitColourTie(
      ColourPairs(options), options.matrix ? ColourTieKind::kMatrix : ColourTieKind::kScale);
  calibration.room_from_fisheye_rgb = tie.to_from_rgb;
  WriteWholeText(options.out.empty() ? options.calibration : options.out,
                 FisheyeCalibrationText(calibration));
  std::string report;
  for (int row = 0; row < 3; ++row) {
    report += Line("%10.5f %10.5f %10.5f",
                   tie.to_from_rgb[0][row],
                   tie.to_from_rgb[1][row],
                   tie.to_from_rgb[2][row]);
  }
  for (std::size_t i = 0; i < tie.counts.size(); ++i) {
    if (tie.counts[i]) continue;
    report += Line("pair %zu left out: off by %.1f %%", i + 1, 100.0 * tie.residual_relative[i]);
  }
  return report + Line("rms %.2f %% over %td pairs",
                       100.0 * tie.rms_relative,
                       std::count(tie.counts.begin(), tie.counts.end(), true));
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
  calibration.world_from_camera = fit.world_from_camera;
  WriteWholeText(options.out.empty() ? options.calibration : options.out,
                 FisheyeCalibrationText(calibration));

  std::string report;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    report += Line("%s: off by %.3f deg%s",
                   marks[i].name.c_str(),
                   DegFromRad(fit.residual_rad[i]),
                   fit.counts[i] ? "" : ", left out");
  }
  const glm::dvec3 axis = fit.world_from_camera[2];
  const glm::dvec3 up = -fit.world_from_camera[1];
  return report + Line(
                      "rms %.3f deg; the axis is %.2f deg from the zenith, the picture's up has "
                      "azimuth %.2f deg",
                      DegFromRad(fit.rms_rad),
                      DegFromRad(std::atan2(std::hypot(axis.x, axis.y), axis.z)),
                      DegFromRad(std::atan2(up.x, up.y)) + (up.x < 0.0 ? 360.0 : 0.0));
}

}  // namespace pleinair
