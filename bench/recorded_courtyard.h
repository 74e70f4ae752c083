// The recorded courtyard's frame 6, prepared, and a camera that is held in the hand there.
#pragma once

#include <cstdlib>
#include <filesystem>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include "bench/recorded_place.h"

namespace pleinair {

inline const std::filesystem::path kRecordedCourtyard =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";

struct RecordedCourtyard : RecordedPlace {
  RecordedCourtyard() : RecordedPlace(kRecordedCourtyard, 6) {}
};

// The pose of frame `i`: a centimetre and a milliradian a frame, half a metre to the right and as
// many milliradians round, and back.
inline glm::dmat4 HeldInTheHand(const glm::dmat4& camera_from_world, int i) {
  constexpr int kSteps = 50;
  const int step = kSteps - std::abs(i % (2 * kSteps) - kSteps);
  const glm::dmat4 turned = glm::rotate(glm::dmat4(1.0), 1e-3 * step, glm::dvec3(0.0, 1.0, 0.0));
  return glm::translate(glm::dmat4(1.0), glm::dvec3(-0.01 * step, 0.0, 0.0)) * turned *
         camera_from_world;
}

}  // namespace pleinair
