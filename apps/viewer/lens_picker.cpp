#include "apps/viewer/lens_picker.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "datasets/picture_source.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// As FitLens expects them.
constexpr std::size_t kFewestCorners = 6;

// With the corners that a person has edited, and whether it is used in any case.
SeenBoard AsChosen(SeenBoard seen, const TakenBoard& taken, const CalibrationBoard& board) {
  if (!seen.board) return seen;
  if (taken.edited && taken.edited->board == board) seen.board->corners = taken.edited->corners;
  seen.board->is_always_used = taken.use == BoardUse::kAlways;
  return seen;
}

// The same for the fit, which refuses too few corners.
SeenBoard ForFit(SeenBoard seen) {
  if (seen.board && seen.board->corners.size() < kFewestCorners) {
    seen.board = tl::unexpected(fmt::format(
        "expected {} corners or more, {} are left", kFewestCorners, seen.board->corners.size()));
  }
  return seen;
}

std::string ReasonFor(const std::string& name, const BoardLens& lens) {
  const auto find = [&](const std::vector<RejectedPicture>& pictures) -> const std::string* {
    const auto found = std::find_if(pictures.begin(), pictures.end(), [&](const auto& picture) {
      return picture.name == name;
    });
    return found == pictures.end() ? nullptr : &found->reason;
  };
  if (const std::string* reason = find(lens.unused)) return *reason;
  if (!lens.choice) return {};
  const std::string* reason = find(lens.choice->fit.rejected);
  return reason == nullptr ? std::string() : *reason;
}

bool IsOfSize(const SeenBoard& seen, const AnyLens& lens) {
  return std::visit(
      [&](const auto& model) {
        return seen.width_px == model.width_px && seen.height_px == model.height_px;
      },
      lens);
}

std::string NameOf(const std::string& file_or_frame) {
  return std::filesystem::path(file_or_frame).filename().string();
}

}  // namespace

LensPicker::LensPicker(std::filesystem::path file, std::function<void()> wake)
    : file_(std::move(file)), wake_(std::move(wake)) {}

LensPicker::~LensPicker() = default;

void LensPicker::NextLook() {
  ++looks_;
  wake_();
}

tl::expected<CalibrationBoard, std::string> LensPicker::BoardOf(const LensBoards& boards,
                                                                const std::stop_token& stop) {
  if (boards.size) return CalibrationBoard{*boards.size, boards.markers};
  if (boards.markers) {
    return tl::unexpected(
        std::string("a ChArUco board: its numbers of inner corners have to be entered"));
  }
  LensPictures pictures;
  for (const TakenBoard& taken : boards.pictures) {
    if (taken.use != BoardUse::kNever) pictures.push_back(taken.picture);
  }
  const std::vector<BoardSize> sizes = SizesSeen(pictures, [&] {
    NextLook();
    return !stop.stop_requested();
  });
  if (stop.stop_requested()) return tl::unexpected(std::string("stopped"));
  if (sizes.empty()) return tl::unexpected(std::string("no chessboard is seen in the pictures"));
  if (sizes.size() > 1) {
    if (const auto best = BestSize(pictures, sizes, boards.model)) {
      return CalibrationBoard{best->size, {}};
    }
  }
  // Of too few pictures for a lens.
  return CalibrationBoard{
      *std::max_element(sizes.begin(),
                        sizes.end(),
                        [](BoardSize a, BoardSize b) { return a.Count() < b.Count(); }),
      {}};
}

LensPicker::Found LensPicker::Look(const LensBoards& boards, const std::stop_token& stop) {
  Found found;
  const auto board = BoardOf(boards, stop);
  if (!board) {
    found.failure = board.error();
    return found;
  }
  board->Validate();
  found.board = *board;
  looks_ = 0;
  std::vector<SeenBoard> all;
  std::vector<SeenBoard> used;
  for (const TakenBoard& taken : boards.pictures) {
    if (stop.stop_requested()) return found;
    all.push_back(AsChosen(taken.picture->LookAt(*board), taken, *board));
    if (taken.use != BoardUse::kNever) used.push_back(ForFit(all.back()));
    NextLook();
  }
  if (used.empty()) {
    found.failure = "all pictures are left out";
  } else {
    found.lens = FitBoards(used, boards.model);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const SeenBoard& seen = all[i];
    BoardResult result{seen.board, {}, {}, {}};
    const bool is_left_out = boards.pictures[i].use == BoardUse::kNever;
    result.left_out = is_left_out ? "by hand" : ReasonFor(seen.name, found.lens);
    if (found.lens.choice) {
      const LensFit& fit = found.lens.choice->fit;
      for (const FittedPicture& picture : fit.fitted) {
        if (picture.name == seen.name) result.rms_px = picture.rms_px;
      }
      if (seen.board && IsOfSize(seen, fit.lens)) result.fit = FitBoard(fit.lens, *seen.board);
    }
    found.results.emplace_back(boards.pictures[i].picture, std::move(result));
  }
  return found;
}

void LensPicker::Start() {
  is_old_ = false;
  looks_ = 0;
  if (now_.pictures.empty()) {
    found_ = {};
    return;
  }
  thread_ = std::jthread([this, boards = now_](const std::stop_token& stop) {
    Found found;
    try {
      found = Look(boards, stop);
    } catch (const std::exception& error) {
      found.failure = error.what();
    }
    {
      const std::lock_guard lock(mutex_);
      result_ = std::move(found);
    }
    wake_();
  });
}

void LensPicker::Restart() {
  // What a person has edited is shown until it is fitted.
  for (const TakenBoard& taken : now_.pictures) {
    const auto index = IndexOfResult(taken.picture.get());
    if (!index || !taken.edited || taken.edited->board != *found_.board) continue;
    BoardResult& result = found_.results[*index].second;
    if (!result.board) continue;
    result.board->corners = taken.edited->corners;
    if (found_.lens.choice) result.fit = FitBoard(found_.lens.choice->fit.lens, *result.board);
  }
  if (!IsBusy()) return Start();
  is_old_ = true;
  thread_.request_stop();
}

void LensPicker::TakeResult() {
  thread_.join();
  std::optional<Found> result;
  {
    const std::lock_guard lock(mutex_);
    result = std::exchange(result_, std::nullopt);
  }
  if (is_old_) return Start();
  found_ = std::move(*result);
}

bool LensPicker::Poll() {
  if (!IsBusy()) return false;
  const std::size_t looks = looks_;
  const bool has_looked = std::exchange(shown_looks_, looks) != looks;
  bool is_done = false;
  {
    const std::lock_guard lock(mutex_);
    is_done = result_.has_value();
  }
  // A corner that is held stays where it is.
  if (!is_done || held_) return has_looked;
  TakeResult();
  return true;
}

void LensPicker::Await() {
  while (IsBusy()) TakeResult();
}

std::optional<std::size_t> LensPicker::IndexOfResult(const LensPicture* picture) const {
  for (std::size_t i = 0; i < found_.results.size(); ++i) {
    if (found_.results[i].first.get() == picture) return i;
  }
  return std::nullopt;
}

const BoardResult* LensPicker::ResultOf(std::size_t index) const {
  const auto result = IndexOfResult(now_.pictures.at(index).picture.get());
  return result ? &found_.results[*result].second : nullptr;
}

BoardResult* LensPicker::ShownResult() {
  const auto index = Selected() ? IndexOfResult(selected_.get()) : std::nullopt;
  if (!index || !found_.results[*index].second.board) return nullptr;
  return &found_.results[*index].second;
}

std::string LensPicker::DescribePicture(std::size_t index) const {
  const TakenBoard& taken = now_.pictures.at(index);
  std::string text = NameOf(taken.picture->Name());
  const BoardResult* result = ResultOf(index);
  if (result == nullptr) return text;
  if (result->rms_px) {
    text += fmt::format(": rms {:.2f} px", *result->rms_px);
    if (taken.use == BoardUse::kAlways) text += ", always used";
  } else if (!result->left_out.empty()) {
    text += ": left out: " + result->left_out;
  } else if (!result->board) {
    text += ": " + result->board.error();
  }
  if (taken.edited) text += " (corners edited)";
  return text;
}

std::string LensPicker::Describe() const {
  const std::size_t count = now_.pictures.size();
  if (IsBusy()) {
    return looks_ < count ? fmt::format("looking at picture {} of {}", looks_ + 1, count)
                          : std::string("fitting the lens");
  }
  if (count == 0) return "take pictures of a board, or open files of them";
  if (!found_.failure.empty()) return found_.failure;
  const std::string board = "board " + TextOf(found_.board->size) + ": ";
  if (!found_.lens.choice) return board + found_.lens.doubt;
  const LensFit& fit = found_.lens.choice->fit;
  std::string text = fmt::format("{}{}: fx {:.1f}, fy {:.1f}; {:.3f} px rms, {} of {} pictures",
                                 board,
                                 LensModelName(fit.Model()),
                                 fit.FxPx(),
                                 fit.FyPx(),
                                 fit.rms_px,
                                 fit.fitted.size(),
                                 count);
  text += fmt::format("; boards to {:.1f} deg from the axis", DegFromRad(fit.covered_angle_rad));
  if (!found_.lens.doubt.empty()) text += "; in doubt: " + found_.lens.doubt;
  return text;
}

void LensPicker::Edit(const std::function<void(LensBoards&)>& edit) {
  LetGo();
  undo_.Remember(now_);
  edit(now_);
  Restart();
}

std::string LensPicker::Take(const ViewedFrame& frame) {
  if (!frame.step.frame || !frame.step.frame->codes) {
    return "lens: expected an 8-bit picture of the camera, found a linear one";
  }
  const std::string frame_name = fmt::format("frame {}", frame.step.frame->index);
  std::string name = frame_name;
  for (int again = 2; names_.contains(name); ++again) {
    name = fmt::format("{} ({})", frame_name, again);
  }
  const auto codes = std::make_shared<const Rgb8Image>(*frame.step.frame->codes);
  names_.insert(name);
  Edit([&](LensBoards& boards) {
    boards.pictures.push_back(
        {std::make_shared<LensPicture>(name, [codes] { return *codes; }), {}, {}});
  });
  return name + " is taken";
}

std::string LensPicker::Open(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files{file};
  if (std::filesystem::is_directory(file)) files = PictureFilesIn(file);
  std::erase_if(files, [&](const std::filesystem::path& one) {
    return std::any_of(now_.pictures.begin(), now_.pictures.end(), [&](const TakenBoard& taken) {
      return taken.picture->Name() == one.string();
    });
  });
  if (files.empty()) return file.string() + ": its pictures are there already";
  for (const std::filesystem::path& one : files) {
    if (!std::filesystem::is_regular_file(one)) {
      throw std::runtime_error(one.string() + ": expected a picture's file, or a folder of them");
    }
  }
  Edit([&](LensBoards& boards) {
    for (const std::filesystem::path& one : files) {
      boards.pictures.push_back({std::make_shared<LensPicture>(one), {}, {}});
    }
  });
  return fmt::format("{} pictures of {} are opened", files.size(), file.string());
}

void LensPicker::Delete(std::size_t index) {
  if (Selected() == index) Select(std::nullopt);
  Edit([&](LensBoards& boards) {
    boards.pictures.erase(boards.pictures.begin() + static_cast<std::ptrdiff_t>(index));
  });
}

std::string LensPicker::ToggleUse(std::size_t index) {
  const BoardResult* result = ResultOf(index);
  const std::string name = NameOf(now_.pictures.at(index).picture->Name());
  const BoardUse before = now_.pictures[index].use;
  BoardUse after = BoardUse::kWhereItFits;
  if (before != BoardUse::kNever) {
    const bool is_left_out = result != nullptr && !result->left_out.empty();
    if (is_left_out && !result->board) return name + ": " + result->board.error();
    after = is_left_out ? BoardUse::kAlways : BoardUse::kNever;
  }
  Edit([&](LensBoards& boards) { boards.pictures[index].use = after; });
  return name + (after == BoardUse::kNever    ? " is left out"
                 : after == BoardUse::kAlways ? " is used, whatever its fit"
                                              : " is used where it fits");
}

void LensPicker::SetSize(std::optional<BoardSize> size) {
  if (size != now_.size) Edit([&](LensBoards& boards) { boards.size = size; });
}

void LensPicker::SetMarkers(std::optional<CharucoMarkers> markers) {
  if (markers != now_.markers) Edit([&](LensBoards& boards) { boards.markers = markers; });
}

void LensPicker::SetModel(std::optional<LensModel> model) {
  if (model != now_.model) Edit([&](LensBoards& boards) { boards.model = model; });
}

std::optional<std::size_t> LensPicker::Selected() const {
  for (std::size_t i = 0; i < now_.pictures.size(); ++i) {
    if (selected_ && now_.pictures[i].picture == selected_) return i;
  }
  return std::nullopt;
}

std::string LensPicker::Select(std::optional<std::size_t> index) {
  LetGo();
  selected_.reset();
  shown_.reset();
  if (!index) return "the camera's picture";
  const auto& picture = now_.pictures.at(*index).picture;
  try {
    shown_ = std::make_shared<const Rgb8Image>(picture->Read());
  } catch (const std::exception& error) {
    return error.what();
  }
  selected_ = picture;
  return DescribePicture(*index);
}

std::string LensPicker::SelectNext(int step) {
  const int count = static_cast<int>(now_.pictures.size()) + 1;
  const auto selected = Selected();
  const int now = selected ? static_cast<int>(*selected) : count - 1;
  const int next = (now + step + count) % count;
  return Select(next == count - 1 ? std::nullopt : std::optional(static_cast<std::size_t>(next)));
}

std::optional<std::size_t> LensPicker::CornerNear(const glm::dvec2& pixel, double reach_px) {
  const BoardResult* result = ShownResult();
  if (result == nullptr) return std::nullopt;
  std::optional<std::size_t> nearest;
  const std::vector<BoardCorner>& corners = result->board->corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double distance_px = glm::distance(corners[i].pixel, pixel);
    if (!(distance_px < reach_px)) continue;
    reach_px = distance_px;
    nearest = i;
  }
  return nearest;
}

void LensPicker::EditCorners(const std::function<void(std::vector<BoardCorner>&)>& change) {
  BoardResult& result = *ShownResult();
  change(result.board->corners);
  if (found_.lens.choice) result.fit = FitBoard(found_.lens.choice->fit.lens, *result.board);
  now_.pictures[*Selected()].edited = EditedCorners{*found_.board, result.board->corners};
}

std::string LensPicker::Press(const glm::dvec2& pixel, double reach_px) {
  LetGo();
  if (!Selected()) return "choose one of the pictures that were taken: Tab";
  const auto corner = CornerNear(pixel, reach_px);
  if (!corner) return "no corner of the board there";
  held_ = Held{*corner, *ShownResult()};
  undo_.Remember(now_);
  const BoardResult& result = *ShownResult();
  return result.fit ? fmt::format("off by {:.2f} px", glm::length(result.fit->residual_px[*corner]))
                    : std::string();
}

void LensPicker::MoveTo(const glm::dvec2& pixel) {
  if (!held_) return;
  held_->has_moved = true;
  EditCorners([&](std::vector<BoardCorner>& corners) { corners[held_->corner].pixel = pixel; });
}

void LensPicker::Release() {
  if (!held_) return;
  const bool has_moved = held_->has_moved;
  held_.reset();
  if (has_moved) {
    Restart();
  } else {
    undo_.Drop(now_);
  }
}

void LensPicker::LetGo() {
  if (!held_) return;
  *ShownResult() = std::move(held_->before);
  held_.reset();
  undo_.Drop(now_);
}

std::string LensPicker::RemoveCorner(const glm::dvec2& pixel, double reach_px) {
  LetGo();
  if (!Selected()) return "choose one of the pictures that were taken: Tab";
  const auto corner = CornerNear(pixel, reach_px);
  if (!corner) return "no corner of the board there";
  undo_.Remember(now_);
  EditCorners([&](std::vector<BoardCorner>& corners) {
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(*corner));
  });
  Restart();
  return fmt::format("{} corners are left", ShownResult()->board->corners.size());
}

std::string LensPicker::FindCorners() {
  const auto selected = Selected();
  if (!selected) return "choose one of the pictures that were taken: Tab";
  if (now_.pictures[*selected].edited) {
    Edit([&](LensBoards& boards) { boards.pictures[*selected].edited.reset(); });
  }
  return "all corners as they are found";
}

std::optional<glm::dvec2> LensPicker::NextCorner(const glm::dvec2& pixel) const {
  const auto selected = Selected();
  const BoardResult* result = selected ? ResultOf(*selected) : nullptr;
  if (result == nullptr || !result->board || result->board->corners.empty()) return std::nullopt;
  const std::vector<BoardCorner>& corners = result->board->corners;
  std::vector<std::size_t> order(corners.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  if (result->fit) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return glm::length(result->fit->residual_px[a]) > glm::length(result->fit->residual_px[b]);
    });
  }
  const auto here = std::find_if(
      order.begin(), order.end(), [&](std::size_t i) { return corners[i].pixel == pixel; });
  const bool is_last = here == order.end() || here + 1 == order.end();
  return corners[is_last ? order.front() : *(here + 1)].pixel;
}

void LensPicker::Undo() {
  LetGo();
  if (undo_.Undo(now_)) Restart();
}

void LensPicker::Redo() {
  LetGo();
  if (undo_.Redo(now_)) Restart();
}

bool LensPicker::HasUnsavedPicks() const { return !now_.pictures.empty() && now_ != saved_; }

std::string LensPicker::Save(bool is_forced) {
  Release();
  Await();
  if (!found_.lens.choice) throw std::runtime_error("lens: no lens yet: " + Describe());
  if (!found_.lens.doubt.empty() && !is_forced) {
    throw std::runtime_error("lens: not saved, since it is in doubt: " + found_.lens.doubt);
  }
  std::string set = WriteSiteLens(found_.lens.choice->fit, file_);
  saved_ = now_;
  return set;
}

}  // namespace pleinair
