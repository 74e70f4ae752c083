#include "apps/board_lens.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calib/fisheye_file.h"
#include "calib/json_cursor.h"
#include "datasets/new_site.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
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

// `message` without the file that it begins with.
std::string WithoutFile(const std::string& message, const std::string& file) {
  const std::string name = file + ": ";
  return message.starts_with(name) ? message.substr(name.size()) : message;
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

tl::expected<BoardPicture, std::string> BoardIn(const Gray8Image& green,
                                                const CalibrationBoard& board,
                                                const std::string& name) {
  auto corners = FindBoardCorners(green, board);
  if (!corners) return tl::unexpected(std::move(corners.error()));
  const double edge_width_px = BoardEdgeWidthPx(green, board, *corners);
  return BoardPicture{name, std::move(*corners), edge_width_px};
}

}  // namespace

LensPicture::LensPicture(const std::filesystem::path& file)
    : LensPicture(file.string(), [file] { return ReadDisplayImage(file); }) {}

const SeenBoard& LensPicture::LookAt(const CalibrationBoard& board) const {
  const auto known = std::find_if(
      seen_.begin(), seen_.end(), [&](const Seen& looked_at) { return looked_at.board == board; });
  if (known != seen_.end()) return known->seen;
  SeenBoard seen{name_, 0, 0, tl::unexpected(std::string())};
  try {
    const Gray8Image green = GreenOf(Read());
    seen.width_px = green.width;
    seen.height_px = green.height;
    seen.board = BoardIn(green, board, name_);
  } catch (const std::exception& error) {
    seen.board = tl::unexpected(WithoutFile(error.what(), name_));
  }
  return seen_.emplace_back(Seen{board, std::move(seen)}).seen;
}

std::optional<BoardSize> LensPicture::SizeSeen() const {
  if (!size_seen_) {
    try {
      size_seen_ = FindBoardSize(GreenOf(Read()));
    } catch (const std::exception&) {
      size_seen_ = std::optional<BoardSize>();  // LookAt says why it cannot be read.
    }
  }
  return *size_seen_;
}

std::vector<SeenBoard> LookAtAll(const LensPictures& pictures, const CalibrationBoard& board) {
  std::vector<SeenBoard> seen;
  seen.reserve(pictures.size());
  for (const auto& picture : pictures) seen.push_back(picture->LookAt(board));
  return seen;
}

BoardLens FitBoards(std::span<const SeenBoard> pictures, std::optional<LensModel> model) {
  BoardLens lens;
  std::vector<BoardPicture> boards;
  int width = 0;
  int height = 0;
  for (const SeenBoard& picture : pictures) {
    if (width == 0) {
      width = picture.width_px;
      height = picture.height_px;
    }
    if (picture.width_px != 0 && (picture.width_px != width || picture.height_px != height)) {
      lens.unused.push_back({picture.name,
                             fmt::format("{}x{} pixels where the first has {}x{}",
                                         picture.width_px,
                                         picture.height_px,
                                         width,
                                         height)});
    } else if (!picture.board) {
      lens.unused.push_back({picture.name, picture.board.error()});
    } else {
      boards.push_back(*picture.board);
    }
  }
  if (width == 0 && !lens.unused.empty()) {
    throw std::runtime_error(lens.unused[0].name + ": " + lens.unused[0].reason +
                             ": expected pictures of a board");
  }
  for (RejectedPicture& blurred : TakeOutBlurred(boards)) {
    lens.unused.push_back(std::move(blurred));
  }
  const std::vector<RejectedPicture> repeated = TakeOutRepeated(boards);
  lens.repeated = repeated.size();
  lens.unused.insert(lens.unused.end(), repeated.begin(), repeated.end());
  if (boards.empty()) {
    lens.doubt = "expected pictures of a board of so many inner corners, found none";
    if (!lens.unused.empty()) {
      lens.doubt += "; " + lens.unused[0].name + ": " + lens.unused[0].reason;
    }
    return lens;
  }
  constexpr std::size_t kFewestViews = 3;  // Of any lens.
  if (lens.repeated > 0 && boards.size() < kFewestViews) {
    lens.doubt = fmt::format(
        "expected {} different views of the board or more, found {} (pictures that show it where "
        "another one does: {})",
        kFewestViews,
        boards.size(),
        lens.repeated);
    return lens;
  }
  try {
    lens.choice = model ? LensChoice{FitLens(boards, *model, width, height), {}, {}}
                        : ChooseLens(boards, width, height);
    lens.doubt = DoubtAbout(lens.choice->fit);
  } catch (const std::runtime_error& error) {
    lens.doubt = error.what();
  }
  return lens;
}

std::vector<BoardSize> SizesSeen(const LensPictures& pictures,
                                 const std::function<bool()>& goes_on) {
  constexpr std::size_t kPicturesLookedAt = 12;
  std::vector<BoardSize> sizes;
  for (std::size_t i = 0; i < std::min(pictures.size(), kPicturesLookedAt); ++i) {
    const auto seen = pictures[i]->SizeSeen();
    if (seen && std::find(sizes.begin(), sizes.end(), *seen) == sizes.end()) {
      sizes.push_back(*seen);
    }
    if (goes_on && !goes_on()) break;
  }
  return sizes;
}

std::optional<SizedLens> BestSize(const LensPictures& pictures,
                                  std::span<const BoardSize> sizes,
                                  std::optional<LensModel> model) {
  std::vector<BoardSize> largest_first(sizes.begin(), sizes.end());
  std::stable_sort(largest_first.begin(), largest_first.end(), [](BoardSize a, BoardSize b) {
    return a.Count() > b.Count();
  });
  std::optional<SizedLens> best;
  std::size_t most_corners = 0;
  for (const BoardSize size : largest_first) {
    const auto count = static_cast<std::size_t>(size.Count());
    // A size takes seconds: not where its corners would be too few in any case.
    if (pictures.size() * count <= most_corners) break;
    const std::vector<SeenBoard> seen = LookAtAll(pictures, {size, {}});
    const auto boards = static_cast<std::size_t>(std::count_if(
        seen.begin(), seen.end(), [](const SeenBoard& one) { return one.board.has_value(); }));
    if (boards * count <= most_corners) continue;
    BoardLens lens = FitBoards(seen, model);
    if (!lens.choice || !lens.doubt.empty()) continue;
    LensFit& fit = lens.choice->fit;
    const std::size_t corners = fit.fitted.size() * count;
    if (corners <= most_corners) continue;
    most_corners = corners;
    best = SizedLens{size, std::move(fit)};
  }
  return best;
}

std::string LensFileText(const LensFit& fit) {
  if (const auto* fisheye = std::get_if<FisheyeIntrinsics>(&fit.lens)) {
    return FisheyeCalibrationText({*fisheye, {}, {}, fit.rms_px});
  }
  const nlohmann::ordered_json file{{"camera", JsonOf(std::get<CameraIntrinsics>(fit.lens))}};
  return file.dump(1) + "\n";
}

std::string WriteSiteLens(const LensFit& fit, const std::filesystem::path& site) {
  const std::filesystem::path file = SiteFileIn(site);
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  if (const auto* camera = std::get_if<CameraIntrinsics>(&fit.lens)) {
    if (const auto at = root.Optional("camera")) {
      RequireSize(file, *at, camera->width_px, camera->height_px);
    }
    SetSiteLens(file, *camera);
    return file.string() + ": camera: the lens is set";
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
  return file.string() +
         ": fisheye: the lens is set, of a camera that looks at the sky; composites are drawn for "
         "`camera`, a pinhole: --model pinhole fits that";
}

}  // namespace pleinair
