// A lens from pictures of a board, as `calibrate lens` and the window make it: what each picture
// shows, the lens that fits, and the files that it is written to.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "calib/calibration_board.h"
#include "calib/lens_fit.h"
#include "scene/image.h"

namespace pleinair {

// What a picture shows of a board.
struct SeenBoard {
  std::string name;
  int width_px = 0;  // 0: it could not be read.
  int height_px = 0;
  tl::expected<BoardPicture, std::string> board;  // Else what is wrong with it.
};

// A picture that is read when it is needed: many large ones do not fit into memory. What it shows
// is kept.
class LensPicture {
 public:
  // `read` throws where it cannot be read; messages leave out a `name` that they begin with.
  LensPicture(std::string name, std::function<Rgb8Image()> read)
      : name_(std::move(name)), read_(std::move(read)) {}
  explicit LensPicture(const std::filesystem::path& file);

  const std::string& Name() const { return name_; }
  Rgb8Image Read() const { return read_(); }
  // Both look once, on one thread at a time. SizeSeen: of a chessboard; none: none is seen, or the
  // picture cannot be read.
  const SeenBoard& LookAt(const CalibrationBoard& board) const;
  std::optional<BoardSize> SizeSeen() const;

 private:
  std::string name_;
  std::function<Rgb8Image()> read_;
  struct Seen {
    CalibrationBoard board;
    SeenBoard seen;
  };
  mutable std::deque<Seen> seen_;  // References to its elements stay.
  mutable std::optional<std::optional<BoardSize>> size_seen_;
};
using LensPictures = std::vector<std::shared_ptr<const LensPicture>>;

std::vector<SeenBoard> LookAtAll(const LensPictures& pictures, const CalibrationBoard& board);

// What boards give.
struct BoardLens {
  std::optional<LensChoice> choice;
  std::string doubt;  // Why there is none, or it is not credible; or empty.
  // Those not fitted at all: unread, without board, blurred, or as another one.
  std::vector<RejectedPicture> unused;
  std::size_t repeated = 0;  // How many of these show the board where another one does.
};
// `model`: none: the one that predicts held-out pictures better. Throws std::runtime_error where
// not one of the pictures could be read.
BoardLens FitBoards(std::span<const SeenBoard> pictures, std::optional<LensModel> model);

// Returns the sizes of the boards in the first pictures, each size once. `goes_on` is asked after
// each picture; it may be empty.
std::vector<BoardSize> SizesSeen(const LensPictures& pictures,
                                 const std::function<bool()>& goes_on = {});

struct SizedLens {
  BoardSize size;
  LensFit fit;
};
// The size with a credible lens. Parts of a board also fit, so of several sizes it is the one with
// most corners in all.
std::optional<SizedLens> BestSize(const LensPictures& pictures,
                                  std::span<const BoardSize> sizes,
                                  std::optional<LensModel> model);

// {"camera": ...}, or a fish-eye's file.
std::string LensFileText(const LensFit& fit);
// As `camera` or, with fisheye.json, `fisheye` of the folder's or file's site. Returns which of
// them it has become, in a line. Throws std::runtime_error naming the file, also where it is for
// pictures of another size.
std::string WriteSiteLens(const LensFit& fit, const std::filesystem::path& site);

}  // namespace pleinair
