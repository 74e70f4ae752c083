#include "apps/calibrate_lens_command.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/board_lens.h"
#include "scene/whole_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

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

LensPictures PicturesOf(const std::vector<std::filesystem::path>& files) {
  LensPictures pictures;
  pictures.reserve(files.size());
  for (const std::filesystem::path& file : files) {
    pictures.push_back(std::make_shared<LensPicture>(file));
  }
  return pictures;
}

// What the pictures show, and which of them are used whatever they do.
std::vector<SeenBoard> BoardsOf(const CalibrateLensOptions& options,
                                const LensPictures& pictures,
                                const CalibrationBoard& board) {
  std::vector<SeenBoard> boards = LookAtAll(pictures, board);
  for (const std::filesystem::path& file : options.always_used) {
    const auto stated = std::find_if(boards.begin(), boards.end(), [&](const SeenBoard& seen) {
      return seen.name == file.string();
    });
    if (stated == boards.end()) {
      throw std::invalid_argument("--always-use " + file.string() +
                                  ": expected one of the pictures that are given");
    }
    if (!stated->board) {
      throw std::runtime_error(file.string() + ": cannot be used: " + stated->board.error());
    }
    stated->board->is_always_used = true;
  }
  return boards;
}

// The size of board that the pictures fit, for a message.
std::string AdviceOnBoard(const LensPictures& pictures,
                          std::optional<LensModel> model,
                          BoardSize wrong) {
  std::vector<BoardSize> sizes = SizesSeen(pictures);
  std::erase_if(sizes, [&](BoardSize size) {
    return size == wrong || size == BoardSize{wrong.rows, wrong.columns};
  });
  const auto best = BestSize(pictures, sizes, model);
  if (!best) return "does not fit, nor does another size that is seen in the pictures";
  return fmt::format(
      "does not fit, --board {} does (rms {:.2f} px, fx {:.1f}, fy {:.1f}, {} pictures)",
      TextOf(best->size),
      best->fit.rms_px,
      best->fit.FxPx(),
      best->fit.FyPx(),
      best->fit.fitted.size());
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
  const LensPictures pictures = PicturesOf(options.pictures);
  const BoardLens trial = FitBoards(BoardsOf(options, pictures, board), options.model);
  if (!trial.doubt.empty() && !(options.force && trial.choice)) {
    constexpr std::size_t kFewestPictures = 3;  // Of any lens.
    std::string advice = "does not fit";
    if (pictures.size() - trial.repeated < kFewestPictures) {
      advice = "cannot be judged";
    } else if (!board.markers) {
      advice = AdviceOnBoard(pictures, options.model, board.size);
    }
    throw std::runtime_error("--board " + TextOf(board.size) + " " + advice + ": " + trial.doubt +
                             (trial.choice ? "; --force writes it all the same" : ""));
  }
  LensFit fit = trial.choice->fit;
  if (options.fov_deg) {
    auto* const fisheye = std::get_if<FisheyeIntrinsics>(&fit.lens);
    if (fisheye == nullptr) {
      throw std::invalid_argument("--fov-deg: expected a fish-eye lens, found a pinhole");
    }
    fisheye->max_angle_rad = 0.5 * RadFromDeg(*options.fov_deg);
  }
  if (!options.out.empty()) WriteWholeText(options.out, LensFileText(fit));
  std::string report;
  if (!options.site.empty()) report += WriteSiteLens(fit, options.site) + "\n";
  for (const FittedPicture& picture : fit.fitted) {
    report += fmt::format("{}: rms {:.2f} px\n", picture.name, picture.rms_px);
  }
  for (const auto& rejected : {trial.unused, fit.rejected}) {
    for (const RejectedPicture& picture : rejected) {
      report += picture.name + ": left out: " + picture.reason + "\n";
    }
  }
  if (trial.repeated > 0) {
    report +=
        fmt::format("pictures that show the board where another one does, and do not count: {}\n",
                    trial.repeated);
  }
  if (!trial.doubt.empty()) report += "forced: " + trial.doubt + "\n";
  return report + DescribeTrial(LensModel::kPinhole, trial.choice->pinhole) +
         DescribeTrial(LensModel::kFisheye, trial.choice->fisheye) + DescribeLens(fit);
}

}  // namespace pleinair
