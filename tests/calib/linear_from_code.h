// The light of a pixel's three codes.
#pragma once

#include <glm/vec3.hpp>

#include "calib/response.h"

namespace pleinair {

inline glm::vec3 LinearFromCode(const ResponseCurve& curve, const glm::u8vec3& code) {
  return {
      curve.LinearOfCode(0)[code.x], curve.LinearOfCode(1)[code.y], curve.LinearOfCode(2)[code.z]};
}

}  // namespace pleinair
