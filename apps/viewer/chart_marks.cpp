#include "apps/viewer/chart_marks.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

constexpr std::array kCornerNames{"dark skin", "bluish green", "black", "white"};

}  // namespace

std::optional<ChartCorners> ChartMarks::Complete() const {
  if (corners_.size() != kCornerNames.size()) return std::nullopt;
  ChartCorners complete;
  std::copy(corners_.begin(), corners_.end(), complete.begin());
  return complete;
}

std::string ChartMarks::Missing() const {
  if (corners_.size() == kCornerNames.size()) return {};
  return fmt::format("press the outer corner of the chart's {}", kCornerNames.at(corners_.size()));
}

std::optional<std::size_t> ChartMarks::Take(const glm::dvec2& pixel, double reach_px) {
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const double distance_px = glm::distance(corners_[i], pixel);
    if (!(distance_px < reach_px)) continue;
    reach_px = distance_px;
    nearest = i;
  }
  if (nearest || corners_.size() == kCornerNames.size()) return nearest;
  corners_.push_back(pixel);
  return corners_.size() - 1;
}

bool ChartMarks::Find(const Rgb8Image& picture) {
  const auto found = FindColourChart(picture);
  if (found) corners_.assign(found->begin(), found->end());
  return found.has_value();
}

}  // namespace pleinair
