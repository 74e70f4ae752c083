#include "calib/reconstruction/internal/wall_outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>

namespace pleinair {
namespace {

enum class Cell { kUnknown, kWall, kOpen };

class Grid {
 public:
  Grid(const WallRectangle& bounds, double cell_m) : bounds_(bounds) {
    constexpr double kMostCells = 256.0;
    const glm::dvec2 size = bounds.upper - bounds.lower;
    columns_ = static_cast<int>(std::clamp(std::round(size.x / cell_m), 1.0, kMostCells));
    rows_ = static_cast<int>(std::clamp(std::round(size.y / cell_m), 1.0, kMostCells));
    cell_ = {size.x / columns_, size.y / rows_};
    wall_.assign(Count(), 0);
    through_.assign(Count(), 0);
  }

  void Add(std::span<const glm::dvec2> places, bool is_wall) {
    for (const glm::dvec2& place : places) {
      const glm::dvec2 at = (place - bounds_.lower) / cell_;
      if (!(at.x >= 0.0 && at.y >= 0.0 && at.x <= columns_ && at.y <= rows_)) continue;
      const int x = std::min(static_cast<int>(at.x), columns_ - 1);
      const int y = std::min(static_cast<int>(at.y), rows_ - 1);
      ++(is_wall ? wall_ : through_)[Index(x, y)];
    }
  }

  // Squares in which neither was seen are as the nearest ones.
  void Decide() {
    cells_.assign(Count(), Cell::kUnknown);
    std::deque<std::size_t> front;
    for (std::size_t i = 0; i < Count(); ++i) {
      // A wrong match is not a window.
      const bool is_open = through_[i] >= 2 && through_[i] > 2 * wall_[i];
      if (!is_open && wall_[i] == 0) continue;
      cells_[i] = is_open ? Cell::kOpen : Cell::kWall;
      front.push_back(i);
    }
    while (!front.empty()) {
      const std::size_t from = front.front();
      front.pop_front();
      const int x = static_cast<int>(from % columns_);
      const int y = static_cast<int>(from / columns_);
      constexpr std::array<std::array<int, 2>, 4> kSteps = {{{0, -1}, {-1, 0}, {1, 0}, {0, 1}}};
      for (const auto& step : kSteps) {
        const int to_x = x + step[0];
        const int to_y = y + step[1];
        if (to_x < 0 || to_y < 0 || to_x >= columns_ || to_y >= rows_) continue;
        Cell& to = cells_[Index(to_x, to_y)];
        if (to != Cell::kUnknown) continue;
        to = cells_[from];
        front.push_back(Index(to_x, to_y));
      }
    }
  }

  // Squares are as most of those around them: single ones are chance.
  void Smooth() {
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<Cell> before = cells_;
      for (int y = 0; y < rows_; ++y) {
        for (int x = 0; x < columns_; ++x) {
          int balance = 0;
          for (int ny = std::max(0, y - 1); ny <= std::min(rows_ - 1, y + 1); ++ny) {
            for (int nx = std::max(0, x - 1); nx <= std::min(columns_ - 1, x + 1); ++nx) {
              balance += before[Index(nx, ny)] == Cell::kWall ? 1 : -1;
            }
          }
          if (balance != 0) cells_[Index(x, y)] = balance > 0 ? Cell::kWall : Cell::kOpen;
        }
      }
    }
  }

  // Rows of wall, each as tall as it goes.
  std::vector<WallRectangle> Rectangles() {
    std::vector<WallRectangle> found;
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        if (!IsWall(x, y, x + 1)) continue;
        int right = x + 1;
        while (right < columns_ && IsWall(right, y, right + 1)) ++right;
        int top = y + 1;
        while (top < rows_ && IsWall(x, top, right)) ++top;
        for (int taken = y; taken < top; ++taken) {
          for (int c = x; c < right; ++c) cells_[Index(c, taken)] = Cell::kOpen;
        }
        found.push_back({Corner(x, y), Corner(right, top)});
      }
    }
    return found;
  }

 private:
  std::size_t Count() const { return static_cast<std::size_t>(columns_) * rows_; }
  std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y) * columns_ + x; }
  bool IsWall(int left, int y, int right) const {
    for (int x = left; x < right; ++x) {
      if (cells_[Index(x, y)] != Cell::kWall) return false;
    }
    return true;
  }
  glm::dvec2 Corner(int x, int y) const {
    return {x == columns_ ? bounds_.upper.x : bounds_.lower.x + x * cell_.x,
            y == rows_ ? bounds_.upper.y : bounds_.lower.y + y * cell_.y};
  }

  WallRectangle bounds_;
  int columns_ = 1;
  int rows_ = 1;
  glm::dvec2 cell_{1.0};
  std::vector<int> wall_;
  std::vector<int> through_;
  std::vector<Cell> cells_;
};

}  // namespace

std::vector<WallRectangle> OutlineWall(const WallRectangle& bounds,
                                       std::span<const glm::dvec2> on_wall,
                                       std::span<const glm::dvec2> seen_through,
                                       double cell_m) {
  Grid grid(bounds, cell_m);
  grid.Add(on_wall, true);
  grid.Add(seen_through, false);
  grid.Decide();
  grid.Smooth();
  return grid.Rectangles();
}

}  // namespace pleinair
