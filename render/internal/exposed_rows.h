// Motions over the exposure of each of a camera's rows.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/mat4x4.hpp>

#include "scene/exposure_motion.h"

namespace pleinair {

// Values at the beginning and the end of the exposure, by the camera's row: of a single one where
// all rows are exposed together.
struct ExposedRows {
  std::vector<glm::dmat4> start;
  std::vector<glm::dmat4> end;

  std::size_t IndexOf(double row) const {
    const double last = static_cast<double>(start.size()) - 1.0;
    return static_cast<std::size_t>(std::lround(std::clamp(row, 0.0, last)));
  }
};

// `at_time` gives the value at a time in seconds from the frame's instant.
template <typename AtTime>
ExposedRows OverRows(const ExposureMotion& motion, int height, const AtTime& at_time) {
  ExposedRows values;
  const int rows = motion.readout_s > 0.0 ? height : 1;
  for (int row = 0; row < rows; ++row) {
    const double middle_s = rows > 1 ? motion.MiddleOfRowS(row, height) : 0.0;
    values.start.push_back(at_time(middle_s - 0.5 * motion.exposure_s));
    values.end.push_back(at_time(middle_s + 0.5 * motion.exposure_s));
  }
  return values;
}

}  // namespace pleinair
