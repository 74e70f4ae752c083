// The camera's lens from pictures of a board that a person takes in the window, or opens.
#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <tl/expected.hpp>

#include "apps/board_lens.h"
#include "apps/viewer/undo_stack.h"
#include "apps/viewer/viewed_frame.h"
#include "calib/board_fit.h"

namespace pleinair {

// Whether the lens is fitted to a picture: where it fits, or as a person says.
enum class BoardUse { kWhereItFits, kNever, kAlways };

// Corners as a person has moved or removed them; of that board alone.
struct EditedCorners {
  CalibrationBoard board;
  std::vector<BoardCorner> corners;

  bool operator==(const EditedCorners&) const = default;
};

struct TakenBoard {
  std::shared_ptr<const LensPicture> picture;
  BoardUse use = BoardUse::kWhereItFits;
  std::optional<EditedCorners> edited;  // None: as they are found.

  bool operator==(const TakenBoard&) const = default;
};

// All that a person has chosen.
struct LensBoards {
  std::vector<TakenBoard> pictures;
  std::optional<BoardSize> size;          // None: as the pictures show it.
  std::optional<CharucoMarkers> markers;  // None: a chessboard.
  std::optional<LensModel> model;         // None: the one that predicts pictures better.

  bool operator==(const LensBoards&) const = default;
};

// What was found in a picture.
struct BoardResult {
  tl::expected<BoardPicture, std::string> board;
  std::string left_out;          // Why; empty: the lens is fitted to it.
  std::optional<double> rms_px;  // Residual of the lens's fit to it; none: it is left out.
  std::optional<BoardFit> fit;   // To the lens; none: no lens, or no board.
};

// Looks at pictures and fits on a thread of its own; all calls come from one other thread.
class LensPicker {
 public:
  // `file`: of the site that Save writes to. `wake` is called from that thread where there is news.
  LensPicker(std::filesystem::path file, std::function<void()> wake);
  // Waits for the picture that is looked at.
  ~LensPicker();
  LensPicker(const LensPicker&) = delete;
  LensPicker& operator=(const LensPicker&) = delete;

  // Takes what was found. True where there is something new to show.
  bool Poll();
  bool IsBusy() const { return thread_.joinable(); }
  // Until it is not busy.
  void Await();

  const LensBoards& Boards() const { return now_; }
  // The result of picture `index`; null: it was not looked at yet.
  const BoardResult* ResultOf(std::size_t index) const;
  std::string DescribePicture(std::size_t index) const;
  // The board of the pictures that were looked at, once its size is known, and their lens.
  const std::optional<CalibrationBoard>& Board() const { return found_.board; }
  const BoardLens& Lens() const { return found_.lens; }
  std::string Describe() const;

  // The frame's picture. Each returns what there is to say of it, in a line.
  std::string Take(const ViewedFrame& frame);
  // A picture's file, or a folder of them. Throws std::runtime_error where there is none.
  std::string Open(const std::filesystem::path& file);
  void Delete(std::size_t index);
  // Leaves a picture out that is used; takes one in that is left out.
  std::string ToggleUse(std::size_t index);
  void SetSize(std::optional<BoardSize> size);
  void SetMarkers(std::optional<CharucoMarkers> markers);
  void SetModel(std::optional<LensModel> model);

  // The picture that is shown in place of the camera's; none: the camera's own is.
  std::optional<std::size_t> Selected() const;
  // Returns what there is to say of it, in a line.
  std::string Select(std::optional<std::size_t> index);
  // One on, or back; the camera's own comes after the last.
  std::string SelectNext(int step);
  const std::shared_ptr<const Rgb8Image>& Shown() const { return shown_; }

  // Takes the corner of the selected picture within reach. Returns why not, in a line.
  std::string Press(const glm::dvec2& pixel, double reach_px);
  // Its residuals are to the lens that was found last.
  void MoveTo(const glm::dvec2& pixel);
  // Fits: not while a corner moves.
  void Release();
  // In place of Release: all is as before Press.
  void LetGo();
  std::string RemoveCorner(const glm::dvec2& pixel, double reach_px);
  // As they are found, in place of those that were edited.
  std::string FindCorners();
  // That whose residual is next in size to that of the corner at `pixel`; the worst one comes
  // first, and after the best one.
  std::optional<glm::dvec2> NextCorner(const glm::dvec2& pixel) const;

  void Undo();
  void Redo();

  // Whether there are pictures, with choices that Save has not yet written a lens of.
  bool HasUnsavedPicks() const;
  // As `calibrate lens --site` writes it. `is_forced`: also one that is in doubt. Waits for it
  // where it is busy. Returns what was set, in a line. Throws std::runtime_error, one line.
  std::string Save(bool is_forced);

 private:
  // What a fit of the chosen pictures gives.
  struct Found {
    std::vector<std::pair<std::shared_ptr<const LensPicture>, BoardResult>> results;
    std::optional<CalibrationBoard> board;
    BoardLens lens;
    std::string failure;  // Why there is no lens; empty: see BoardLens.
  };

  // On its thread.
  Found Look(const LensBoards& boards, const std::stop_token& stop);
  tl::expected<CalibrationBoard, std::string> BoardOf(const LensBoards& boards,
                                                      const std::stop_token& stop);
  void NextLook();

  void Start();
  void Restart();
  void TakeResult();
  void Edit(const std::function<void(LensBoards&)>& edit);
  std::optional<std::size_t> IndexOfResult(const LensPicture* picture) const;
  // The result of the selected picture; null: none, or no board is found in it.
  BoardResult* ShownResult();
  std::optional<std::size_t> CornerNear(const glm::dvec2& pixel, double reach_px);
  // The corners that are shown become edited ones, as `change` leaves them.
  void EditCorners(const std::function<void(std::vector<BoardCorner>&)>& change);

  std::filesystem::path file_;
  std::function<void()> wake_;
  LensBoards now_;
  LensBoards saved_;
  UndoStack<LensBoards> undo_;
  std::set<std::string> names_;  // Names of all frames that were taken.
  std::shared_ptr<const LensPicture> selected_;
  std::shared_ptr<const Rgb8Image> shown_;
  struct Held {
    std::size_t corner = 0;
    BoardResult before;
    bool has_moved = false;
  };
  std::optional<Held> held_;
  Found found_;
  bool is_old_ = false;  // What the thread looks at.

  std::atomic<std::size_t> looks_ = 0;  // Pictures that were looked at.
  std::size_t shown_looks_ = 0;
  std::mutex mutex_;             // For the members that follow.
  std::optional<Found> result_;  // Once the thread is done.
  std::jthread thread_;          // Ends before all that it uses.
};

}  // namespace pleinair
