#include "relight/transport/pixel_blocks.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair {
namespace {

struct Size {
  int width;
  int height;
  int side_px;
};

// Sides that blocks divide and that they do not, and pictures of less than a block.
constexpr std::array<Size, 7> kSizes{
    {{9, 5, 4}, {10, 7, 4}, {12, 8, 4}, {3, 2, 8}, {1, 6, 4}, {1, 1, 4}, {7, 5, 1}}};

constexpr auto kBlankNothing = [](std::size_t) {};

TEST(PixelBlocks, EachPixelIsDoneOnce) {
  for (const Size& size : kSizes) {
    const PixelBlocks blocks(size.width, size.height, size.side_px);
    Gray8Image done(size.width, size.height, 0);
    ForBlocks(
        blocks,
        [&](int y, std::span<const std::uint8_t> wanted) {
          for (int x = 0; x < size.width; ++x) done.At(x, y) += wanted[static_cast<std::size_t>(x)];
        },
        [&](int column, int row, const PixelBlock& block) {
          if ((column + row) % 2 == 0) return false;
          block.ForPixelsBetween([&](int x, int y) { ++done.At(x, y); });
          return true;
        },
        kBlankNothing);
    EXPECT_TRUE(std::ranges::all_of(done.pixels, [](std::uint8_t times) { return times == 1; }))
        << size.width << "x" << size.height << " in blocks of " << size.side_px;
  }
}

TEST(PixelBlocks, CornersAreDoneBeforeWhatLiesBetween) {
  for (const Size& size : kSizes) {
    const PixelBlocks blocks(size.width, size.height, size.side_px);
    Gray8Image done(size.width, size.height, 0);
    bool all_were = true;
    ForBlocks(
        blocks,
        [&](int y, std::span<const std::uint8_t> wanted) {
          for (int x = 0; x < size.width; ++x) done.At(x, y) |= wanted[static_cast<std::size_t>(x)];
        },
        [&](int, int, const PixelBlock& block) {
          for (const std::size_t corner : blocks.Corners(block)) {
            all_were = all_were && done.pixels[corner] != 0;
          }
          return true;
        },
        kBlankNothing);
    EXPECT_TRUE(all_were) << size.width << "x" << size.height << " in blocks of " << size.side_px;
  }
}

// A pixel belongs to its block; a corner is done with any block around it.
bool IsDone(const PixelBlocks& blocks, int x, int y) {
  for (int row = 0; row < blocks.Rows(); ++row) {
    for (int column = 0; column < blocks.Columns(); ++column) {
      if (blocks.WorkOf(blocks.Index(column, row)) != PixelBlocks::Work::kDone) continue;
      const PixelBlock block = blocks.At(column, row);
      const bool is_own = x >= block.left && x < block.end_x && y >= block.top && y < block.end_y;
      const bool is_corner =
          (x == block.left || x == block.right) && (y == block.top || y == block.bottom);
      if (is_corner || (is_own && !(blocks.IsCornerColumn(x) && blocks.IsCornerRow(y))))
        return true;
    }
  }
  return false;
}

// In each of several steps other blocks are chosen: what was done and no longer is gets blanked,
// and what is blank is left alone.
TEST(PixelBlocks, ChosenBlocksAreDoneAndTheOthersAreBlank) {
  constexpr int kBlank = 0;
  for (const Size& size : kSizes) {
    if (size.side_px == 1) continue;
    Image<int> image(size.width, size.height, 1);
    PixelBlocks before(size.width, size.height, size.side_px);
    for (int step = 2; step < 6; ++step) {
      PixelBlocks blocks(size.width, size.height, size.side_px);
      std::vector<std::uint8_t> is_chosen(blocks.Count(), 0);
      for (std::size_t i = 0; i < is_chosen.size(); ++i) is_chosen[i] = (i + step) % 3 == 0 ? 1 : 0;
      blocks.Choose(is_chosen, before);
      int blanked = 0;
      ForCorners(
          blocks,
          [&](int y, std::span<const std::uint8_t> wanted) {
            for (int x = 0; x < size.width; ++x) {
              if (wanted[static_cast<std::size_t>(x)] != 0) image.At(x, y) = step;
            }
          },
          [&](std::size_t pixel) { image.pixels[pixel] = kBlank; });
      ForBetweenCorners(
          blocks,
          [&](int y, std::span<const std::uint8_t> wanted) {
            for (int x = 0; x < size.width; ++x) {
              if (wanted[static_cast<std::size_t>(x)] != 0) image.At(x, y) = step;
            }
          },
          [&](int column, int row, const PixelBlock& block) {
            if ((column + row) % 2 == 0) return false;
            block.ForPixelsBetween([&](int x, int y) { image.At(x, y) = step; });
            return true;
          },
          [&](std::size_t pixel) {
            blanked += image.pixels[pixel] != kBlank ? 1 : 0;
            image.pixels[pixel] = kBlank;
          });
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          EXPECT_EQ(image.At(x, y), IsDone(blocks, x, y) ? step : kBlank)
              << size.width << "x" << size.height << ", pixel " << x << " " << y;
        }
      }
      EXPECT_TRUE(blocks.Count() <= 3 || blanked > 0);
      before = blocks;
    }
  }
}

// To some roundings of values below 10; corners and other blocks' pixels stay.
TEST(PixelBlocks, FillsBetweenAsItBlends) {
  for (const Size& size : kSizes) {
    const PixelBlocks blocks(size.width, size.height, size.side_px);
    for (int row = 0; row < blocks.Rows(); ++row) {
      for (int column = 0; column < blocks.Columns(); ++column) {
        const PixelBlock block = blocks.At(column, row);
        const PixelBlock::Blend<float> blend(block, {1.0f, 7.0f, 2.0f, 9.0f});
        Image<float> filled(size.width, size.height, -1.0f);
        blend.FillBetween(filled);
        Image<float> expected(size.width, size.height, -1.0f);
        block.ForPixelsBetween([&](int x, int y) { expected.At(x, y) = blend(x, y); });
        for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
          EXPECT_NEAR(filled.pixels[i], expected.pixels[i], 1e-5f) << i;
        }
      }
    }
  }
}

TEST(PixelBlocks, BlendsAPlaneExactly) {
  const PixelBlocks blocks(11, 7, 4);
  const auto plane = [](int x, int y) {
    return 2.0f * static_cast<float>(x) - 3.0f * static_cast<float>(y);
  };
  for (int row = 0; row < blocks.Rows(); ++row) {
    for (int column = 0; column < blocks.Columns(); ++column) {
      const PixelBlock block = blocks.At(column, row);
      const PixelBlock::Blend<float> blend(block,
                                           {plane(block.left, block.top),
                                            plane(block.right, block.top),
                                            plane(block.left, block.bottom),
                                            plane(block.right, block.bottom)});
      for (int y = block.top; y < block.end_y; ++y) {
        for (int x = block.left; x < block.end_x; ++x) {
          EXPECT_FLOAT_EQ(blend(x, y), plane(x, y)) << x << ", " << y;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pleinair
