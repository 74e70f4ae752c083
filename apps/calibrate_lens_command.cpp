#include "apps/calibrate_lens_command.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "apps/whole_text.h"
#include "calib/fisheye_file.h"
#include "calib/json_cursor.h"
#include "datasets/new_site.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr const char* kFisheyeFile = "fisheye.json";

// The green channel, which most pixels of a sensor measure.
Gray8Image GreenOf(const Rgb8Image& picture) {
  Gray8Image green(picture.width, picture.height);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) green.pixels[i] = picture.pixels[i].y;
  return green;
}

BoardSize BoardSizeFrom(const std::string& text) {
  BoardSize board;
  int length = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &length) != 2 ||
      text.size() != static_cast<std::size_t>(length)) {
    throw std::invalid_argument("--board " + text +
                                ": expected columns and rows of inner corners, such as 8x6");
  }
  return board;
}

// What pictures show when they are assumed to show one board.
struct Trial {
  std::optional<LensChoice> choice;
  std::string doubt;                    // Why there is none, or it is not credible; or empty.
  std::vector<RejectedPicture> unused;  // Those not fitted at all: unread, without board, blurred.
};

// `message` without the file that it begins with.
std::string WithoutFile(const std::string& message, const std::filesystem::path& file) {
  const std::string name = file.string() + ": ";
  return message.starts_with(name) ? message.substr(name.size()) : message;
}

// Throws std::runtime_error where not one of the files can be read.
Trial TryBoard(const CalibrateLensOptions& options, const CalibrationBoard& board) {
  Trial trial;
  std::vector<BoardPicture> boards;
  int width = 0;
  int height = 0;
  for (const std::filesystem::path& file : options.pictures) {
    const auto leave_out = [&](const std::string& reason) {
      trial.unused.push_back({file.string(), reason});
    };
    Gray8Image picture;
    try {
      picture = GreenOf(ReadDisplayImage(file));
    } catch (const std::exception& error) {
      leave_out(WithoutFile(error.what(), file));
      continue;
    }
    if (width == 0) {
      width = picture.width;
      height = picture.height;
    }
    if (picture.width != width || picture.height != height) {
      leave_out(fmt::format(
          "{}x{} pixels where the first has {}x{}", picture.width, picture.height, width, height));
      continue;
    }
    const auto corners = FindBoardCorners(picture, board);
    if (!corners) {
      leave_out(corners.error());
      continue;
    }
    boards.push_back({file.string(), *corners, BoardEdgeWidthPx(picture, board, *corners)});
  }
  if (width == 0 && !trial.unused.empty()) {
    throw std::runtime_error(trial.unused[0].name + ": " + trial.unused[0].reason +
                             ": expected pictures of a board");
  }
  for (RejectedPicture& blurred : TakeOutBlurred(boards)) {
    trial.unused.push_back(std::move(blurred));
  }
  if (boards.empty()) {
    trial.doubt = "expected pictures of a board of so many inner corners, found none";
    if (!trial.unused.empty()) {
      trial.doubt += "; " + trial.unused[0].name + ": " + trial.unused[0].reason;
    }
    return trial;
  }
  try {
    if (options.model) {
      trial.choice = LensChoice{FitLens(boards, *options.model, width, height), {}, {}};
    } else {
      trial.choice = ChooseLens(boards, width, height);
    }
    trial.doubt = DoubtAbout(trial.choice->fit);
  } catch (const std::runtime_error& error) {
    trial.doubt = error.what();
  }
  return trial;
}

// Sizes of chessboard that pictures show, but for `wrong`.
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

// The size of board that the pictures fit, for a message. Parts of a board also fit, so of several
// sizes it is the one with most corners in all.
std::string AdviceOnBoard(const CalibrateLensOptions& options, BoardSize wrong) {
  std::string advice = "does not fit, nor does another size that is seen in the pictures";
  std::size_t most_corners = 0;
  for (const BoardSize size : SizesSeen(options.pictures, wrong)) {
    const Trial trial = TryBoard(options, {size, {}});
    if (!trial.choice || !trial.doubt.empty()) continue;
    const LensFit& fit = trial.choice->fit;
    const std::size_t corners = fit.fitted.size() * static_cast<std::size_t>(size.Count());
    if (corners <= most_corners) continue;
    most_corners = corners;
    advice = fmt::format(
        "does not fit, --board {} does (rms {:.2f} px, fx {:.1f}, fy {:.1f}, {} pictures)",
        TextOf(size),
        fit.rms_px,
        fit.FxPx(),
        fit.FyPx(),
        fit.fitted.size());
  }
  return advice;
}

// Whatever stands in the site was made for pictures of this size.
void RequireSize(const std::filesystem::path& file,
                 const JsonCursor& camera,
                 int width_px,
                 int height_px) {
  const auto width = camera.Optional("width");
  const auto height = camera.Optional("height");
  if (!width || !height) return;
  if (width->Value() == width_px && height->Value() == height_px) return;
  throw std::runtime_error(fmt::format("{}: {}: expected {}x{}, the size of the board's pictures",
                                       file.string(),
                                       camera.Path(),
                                       width_px,
                                       height_px));
}

void WriteIntoSite(const std::filesystem::path& site, const LensFit& fit) {
  const std::filesystem::path file = SiteFileIn(site);
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  if (const auto* camera = std::get_if<CameraIntrinsics>(&fit.lens)) {
    if (const auto at = root.Optional("camera")) {
      RequireSize(file, *at, camera->width_px, camera->height_px);
    }
    SetSiteLens(file, *camera);
    return;
  }
  const FisheyeIntrinsics& lens = std::get<FisheyeIntrinsics>(fit.lens);
  FisheyeCalibration calibration{lens, {}, {}, fit.rms_px};
  std::filesystem::path name = kFisheyeFile;
  if (const auto at = root.Optional("fisheye")) {
    RequireSize(file, *at, lens.width_px, lens.height_px);
    if (const auto before = at->Optional("calibration")) name = before->Text();
  }
  const std::filesystem::path target = file.parent_path() / name;
  std::error_code error;
  if (std::filesystem::exists(target, error)) {
    // The lens is new; how the camera stands and what colours it sees are not.
    const FisheyeCalibration before = ReadFisheyeCalibration(target);
    calibration.world_from_camera = before.world_from_camera;
    calibration.room_from_fisheye_rgb = before.room_from_fisheye_rgb;
  }
  WriteWholeText(target, FisheyeCalibrationText(calibration));
  EditSiteFile(file, [&](nlohmann::ordered_json& json) {
    json["fisheye"].merge_patch({{"model", FisheyeModelName(lens.model)},
                                 {"fov_deg", DegFromRad(2.0 * lens.max_angle_rad)},
                                 {"width", lens.width_px},
                                 {"height", lens.height_px},
                                 {"calibration", name.string()}});
  });
}

std::string DescribeTrial(LensModel model, const LensTrial& trial) {
  if (!trial.failure.empty()) return fmt::format("no {}\n", trial.failure);
  if (!trial.held_out) return {};
  return fmt::format("{}: pictures held out are missed by {:.3f} px (rms); fx sigma {:.2f} px\n",
                     LensModelName(model),
                     trial.held_out->rms_px,
                     trial.held_out->focal_sigma_px);
}

std::string DescribeLens(const LensFit& fit) {
  std::string text = LensModelName(fit.Model());
  double valid_rad = 0.0;
  std::visit(
      [&](const auto& lens) {
        text += fmt::format(": fx {:.2f} fy {:.2f} cx {:.2f} cy {:.2f} px, distortion {:.5f}\n",
                            lens.fx_px,
                            lens.fy_px,
                            lens.cx_px,
                            lens.cy_px,
                            fmt::join(lens.distortion, " "));
      },
      fit.lens);
  if (const auto* lens = std::get_if<FisheyeIntrinsics>(&fit.lens)) {
    valid_rad = FisheyeLens(*lens).MaxAngleRad();
  }
  return text +
         fmt::format("rms {:.3f} px over {} pictures; boards reach {:.1f} deg from the axis",
                     fit.rms_px,
                     fit.fitted.size(),
                     DegFromRad(fit.covered_angle_rad)) +
         (valid_rad > 0.0 ? fmt::format(", valid to {:.1f}\n", DegFromRad(valid_rad)) : "\n");
}

}  // namespace

std::string RunCalibrateLens(const CalibrateLensOptions& options) {
  CalibrationBoard board{BoardSizeFrom(options.board), {}};
  if (options.charuco) board.markers = options.markers;
  board.Validate();
  if (options.out.empty() && options.site.empty()) {
    throw std::invalid_argument("expected --out or --site, to write the lens to");
  }
  const Trial trial = TryBoard(options, board);
  if (!trial.doubt.empty() && !(options.force && trial.choice)) {
    const std::string advice = board.markers ? "does not fit" : AdviceOnBoard(options, board.size);
    throw std::runtime_error("--board " + TextOf(board.size) + " " + advice + ": " + trial.doubt +
                             (trial.choice ? "; --force writes it all the same" : ""));
  }
  LensFit fit = trial.choice->fit;
  auto* const fisheye = std::get_if<FisheyeIntrinsics>(&fit.lens);
  if (options.fov_deg) {
    if (fisheye == nullptr) {
      throw std::invalid_argument("--fov-deg: expected a fish-eye lens, found a pinhole");
    }
    fisheye->max_angle_rad = 0.5 * RadFromDeg(*options.fov_deg);
  }
  if (!options.out.empty()) {
    WriteWholeText(
        options.out,
        fisheye != nullptr
            ? FisheyeCalibrationText({*fisheye, {}, {}, fit.rms_px})
            : nlohmann::ordered_json{{"camera", JsonOf(std::get<CameraIntrinsics>(fit.lens))}}.dump(
                  1) +
                  "\n");
  }
  if (!options.site.empty()) WriteIntoSite(options.site, fit);

  std::string report;
  for (const FittedPicture& picture : fit.fitted) {
    report += fmt::format("{}: rms {:.2f} px\n", picture.name, picture.rms_px);
  }
  for (const auto& rejected : {trial.unused, fit.rejected}) {
    for (const RejectedPicture& picture : rejected) {
      report += picture.name + ": left out: " + picture.reason + "\n";
    }
  }
  if (!trial.doubt.empty()) report += "forced: " + trial.doubt + "\n";
  return report + DescribeTrial(LensModel::kPinhole, trial.choice->pinhole) +
         DescribeTrial(LensModel::kFisheye, trial.choice->fisheye) + DescribeLens(fit);
}

}  // namespace pleinair
