// Saves work where the corners of a block of pixels represent the pixels between them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>

#include "scene/image.h"

namespace pleinair {

// Corners are pixels, shared with the blocks beside.
struct PixelBlock {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
  // Its own are the pixels from (left, top) up to these: no pixel belongs to two blocks.
  int end_x = 0;
  int end_y = 0;

  // Between values at the upper left, upper right, lower left and lower right corner, by place.
  template <class Value>
  class Blend {
   public:
    Blend(const PixelBlock& block, const std::array<Value, 4>& at_corners)
        : left_(block.left),
          top_(block.top),
          right_(block.right),
          bottom_(block.bottom),
          end_x_(block.end_x),
          end_y_(block.end_y),
          at_(at_corners) {
      if (block.right > block.left) per_px_x_ = 1.0f / static_cast<float>(block.right - left_);
      if (block.bottom > block.top) per_px_y_ = 1.0f / static_cast<float>(block.bottom - top_);
    }
    Value operator()(int x, int y) const {
      const float u = static_cast<float>(x - left_) * per_px_x_;
      const float v = static_cast<float>(y - top_) * per_px_y_;
      return (1.0f - v) * ((1.0f - u) * at_[0] + u * at_[1]) +
             v * ((1.0f - u) * at_[2] + u * at_[3]);
    }

    // The same for the block's own pixels that are no corners, row by row: to rounding.
    void FillBetween(Image<Value>& image) const {
      for (int y = top_; y < end_y_; ++y) {
        const float v = static_cast<float>(y - top_) * per_px_y_;
        const Value at_left = (1.0f - v) * at_[0] + v * at_[2];
        const Value step = per_px_x_ * ((1.0f - v) * at_[1] + v * at_[3] - at_left);
        const bool has_corners = y == top_ || y == bottom_;
        Value* const row = image.pixels.data() + image.Index(left_, y);
        for (int i = 0; i < end_x_ - left_; ++i) {
          if (has_corners && (i == 0 || left_ + i == right_)) continue;
          row[i] = at_left + static_cast<float>(i) * step;
        }
      }
    }

   private:
    int left_;
    int top_;
    int right_;
    int bottom_;
    int end_x_;
    int end_y_;
    float per_px_x_ = 0.0f;
    float per_px_y_ = 0.0f;
    std::array<Value, 4> at_;
  };

  // In the same order.
  std::size_t NearestCorner(int x, int y) const {
    return (2 * x > left + right ? 1u : 0u) + (2 * y > top + bottom ? 2u : 0u);
  }

  // Calls visit(x, y) for its own pixels that are no corners of any block.
  template <class Visit>
  void ForPixelsBetween(const Visit& visit) const {
    for (int y = top; y < end_y; ++y) {
      const bool has_corners = y == top || y == bottom;
      for (int x = left; x < end_x; ++x) {
        if (!has_corners || (x != left && x != right)) visit(x, y);
      }
    }
  }
};

// A picture cut into blocks, smaller ones at the right and at the bottom. All of them are done,
// unless some are chosen.
class PixelBlocks {
 public:
  // What happens to a block's pixels, or to a corner, which is done with any block around it.
  enum class Work : std::uint8_t {
    kDone,
    kBlanked,  // Left out, and was done before: it is set to a value that means no surface.
    kKept,     // Left out, and blank already.
  };

  PixelBlocks() = default;
  // In blocks with sides of 1 px all pixels are corners.
  PixelBlocks(int width, int height, int side_px)
      : width_(width),
        height_(height),
        side_px_(std::max(side_px, 1)),
        columns_(BlocksAlong(width)),
        rows_(BlocksAlong(height)) {}

  int Width() const { return width_; }
  int Height() const { return height_; }
  int SidePx() const { return side_px_; }
  int Columns() const { return columns_; }
  int Rows() const { return rows_; }
  std::size_t Count() const {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  }
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  PixelBlock At(int column, int row) const {
    const int left = column * side_px_;
    const int top = row * side_px_;
    return {left,
            top,
            std::min(left + side_px_, width_ - 1),
            std::min(top + side_px_, height_ - 1),
            column + 1 < columns_ ? left + side_px_ : width_,
            row + 1 < rows_ ? top + side_px_ : height_};
  }
  // Indices of pixels: upper left, upper right, lower left and lower right.
  std::array<std::size_t, 4> Corners(const PixelBlock& block) const {
    return {PixelIndex(block.left, block.top),
            PixelIndex(block.right, block.top),
            PixelIndex(block.left, block.bottom),
            PixelIndex(block.right, block.bottom)};
  }

  // Leaves out the blocks for which `is_chosen`, an entry a block, is 0. `before`: as the images
  // were done that are about to be done again.
  void Choose(std::span<const std::uint8_t> is_chosen, const PixelBlocks& before) {
    const bool are_alike =
        before.width_ == width_ && before.height_ == height_ && before.side_px_ == side_px_;
    const auto left_out = [&](Work work_before) {
      return are_alike && work_before != Work::kDone ? Work::kKept : Work::kBlanked;
    };
    work_.resize(Count());
    for (std::size_t i = 0; i < Count(); ++i) {
      work_[i] = is_chosen[i] != 0 ? Work::kDone : left_out(before.WorkOf(i));
    }
    corner_work_.resize(CornerColumns() * (static_cast<std::size_t>(rows_) + 1));
    for (int row = 0; row <= rows_; ++row) {
      for (int column = 0; column <= columns_; ++column) {
        bool is_done = false;
        for (int y = std::max(row - 1, 0); y <= std::min(row, rows_ - 1); ++y) {
          for (int x = std::max(column - 1, 0); x <= std::min(column, columns_ - 1); ++x) {
            is_done = is_done || work_[Index(x, y)] == Work::kDone;
          }
        }
        corner_work_[CornerIndex(column, row)] =
            is_done ? Work::kDone : left_out(before.WorkOfCorner(column, row));
      }
    }
  }
  bool IsWhole() const { return work_.empty(); }
  Work WorkOf(std::size_t block) const { return IsWhole() ? Work::kDone : work_[block]; }
  // Corner (column, row) is the upper left one of the block there.
  Work WorkOfCorner(int column, int row) const {
    return IsWhole() ? Work::kDone : corner_work_[CornerIndex(column, row)];
  }
  std::size_t PixelIndex(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int CornerX(int column) const { return std::min(column * side_px_, width_ - 1); }
  int CornerY(int row) const { return std::min(row * side_px_, height_ - 1); }

  bool IsCornerColumn(int x) const { return x % side_px_ == 0 || x == width_ - 1; }
  bool IsCornerRow(int y) const { return y % side_px_ == 0 || y == height_ - 1; }

 private:
  std::size_t CornerColumns() const { return static_cast<std::size_t>(columns_) + 1; }
  std::size_t CornerIndex(int column, int row) const {
    return static_cast<std::size_t>(row) * CornerColumns() + static_cast<std::size_t>(column);
  }
  int BlocksAlong(int pixels) const { return pixels > 1 ? (pixels - 2) / side_px_ + 1 : pixels; }

  int width_ = 0;
  int height_ = 0;
  int side_px_ = 1;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<Work> work_;         // Per block; empty: all are done.
  std::vector<Work> corner_work_;  // Per corner, row by row.
};

// Which blocks of a view show one plane, corner to corner.
struct PlanarBlocks {
  PixelBlocks blocks;
  std::vector<std::uint8_t> is_planar;  // Per block.
};

// Gives `image` the size of the picture and keeps its memory; its values are unspecified.
template <typename Pixel>
void SizeFor(const PixelBlocks& blocks, Image<Pixel>& image) {
  image.width = blocks.Width();
  image.height = blocks.Height();
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
}

// Do a picture in blocks: first all their corners, then the pixels between each block's corners,
// either all at once or one by one.
//
// do_row(y, wanted)                  does the pixels x of row y with wanted[x] != 0.
// do_between(column, row, block)     does what lies between the block's corners at once, and
//                                    returns true; or false, and that is done by rows.
// blank(pixel)                       blanks a pixel, by its index in the picture.
//
// Rows of blocks are taken in parallel; do_between may write none but the block's own pixels,
// without corners.

template <class DoRow, class Blank>
void ForCorners(const PixelBlocks& blocks, const DoRow& do_row, const Blank& blank) {
  if (blocks.Count() == 0) return;
  tbb::parallel_for(0, blocks.Rows() + 1, [&](int row) {
    const int y = blocks.CornerY(row);
    if (row > 0 && y == blocks.CornerY(row - 1)) return;
    std::vector<std::uint8_t> wanted(static_cast<std::size_t>(blocks.Width()), 0);
    for (int column = 0; column <= blocks.Columns(); ++column) {
      const int x = blocks.CornerX(column);
      const PixelBlocks::Work work = blocks.WorkOfCorner(column, row);
      if (work == PixelBlocks::Work::kDone) wanted[static_cast<std::size_t>(x)] = 1;
      if (work == PixelBlocks::Work::kBlanked) {
        blank(blocks.PixelIndex(x, y));
      }
    }
    do_row(y, wanted);
  });
}

// Blanks all corners that are left out, also those that are blank already.
template <class Blank>
void ForCornersLeftOut(const PixelBlocks& blocks, const Blank& blank) {
  tbb::parallel_for(0, blocks.Rows() + 1, [&](int row) {
    for (int column = 0; column <= blocks.Columns(); ++column) {
      if (blocks.WorkOfCorner(column, row) == PixelBlocks::Work::kDone) continue;
      blank(blocks.PixelIndex(blocks.CornerX(column), blocks.CornerY(row)));
    }
  });
}

template <class DoRow, class DoBetween, class Blank>
void ForBetweenCorners(const PixelBlocks& blocks,
                       const DoRow& do_row,
                       const DoBetween& do_between,
                       const Blank& blank) {
  if (blocks.SidePx() == 1) return;
  tbb::parallel_for(0, blocks.Rows(), [&](int row) {
    std::vector<std::uint8_t> is_left(static_cast<std::size_t>(blocks.Width()), 0);
    bool any_is_left = false;
    for (int column = 0; column < blocks.Columns(); ++column) {
      const PixelBlock block = blocks.At(column, row);
      const PixelBlocks::Work work = blocks.WorkOf(blocks.Index(column, row));
      if (work == PixelBlocks::Work::kBlanked) {
        block.ForPixelsBetween([&](int x, int y) { blank(blocks.PixelIndex(x, y)); });
      }
      if (work != PixelBlocks::Work::kDone || do_between(column, row, block)) continue;
      std::fill(is_left.begin() + block.left, is_left.begin() + block.end_x, std::uint8_t{1});
      any_is_left = true;
    }
    if (!any_is_left) return;
    std::vector<std::uint8_t> between(is_left);
    for (int x = 0; x < blocks.Width(); ++x) {
      if (blocks.IsCornerColumn(x)) between[static_cast<std::size_t>(x)] = 0;
    }
    const PixelBlock first = blocks.At(0, row);
    for (int y = first.top; y < first.end_y; ++y) {
      do_row(y, blocks.IsCornerRow(y) ? between : is_left);
    }
  });
}

template <class DoRow, class DoBetween, class Blank>
void ForBlocks(const PixelBlocks& blocks,
               const DoRow& do_row,
               const DoBetween& do_between,
               const Blank& blank) {
  ForCorners(blocks, do_row, blank);
  ForBetweenCorners(blocks, do_row, do_between, blank);
}

}  // namespace pleinair
