// The corners of a ColorChecker in a picture, as a person sets and moves them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "calib/colour_chart.h"
#include "scene/image.h"

namespace pleinair {

// In the order of ChartCorners; as many as are set.
class ChartMarks {
 public:
  const std::vector<glm::dvec2>& Corners() const { return corners_; }
  std::optional<ChartCorners> Complete() const;
  // What there is to set next, in a line; empty: they are complete.
  std::string Missing() const;

  // The corner within reach of the pixel, or the next one that is missing, which is set there.
  // None: all four are farther away.
  std::optional<std::size_t> Take(const glm::dvec2& pixel, double reach_px);
  void Move(std::size_t corner, const glm::dvec2& pixel) { corners_[corner] = pixel; }
  // As FindColourChart finds them; false where it sees none, and then they stay.
  bool Find(const Rgb8Image& picture);

  bool operator==(const ChartMarks&) const = default;

 private:
  std::vector<glm::dvec2> corners_;
};

}  // namespace pleinair
