// The fish-eye camera of a sequence, from sequence.json and its calibration.
#pragma once

#include <filesystem>
#include <optional>

#include <glm/mat3x3.hpp>

#include "calib/fisheye_camera.h"
#include "datasets/sequence.h"

namespace pleinair {

// Camera and colours of a fish-eye.
struct FisheyeSetup {
  FisheyeCamera camera;
  // Converts radiance of the fish-eye camera to that of the room camera.
  std::optional<glm::dmat3> room_from_fisheye_rgb;
};

// Returns the set-up of the fish-eye camera that `entry` describes; the calibration is read from
// `folder`.
//
// Lens         the calibration's, of the stated model and size, valid up to half the stated field
//              of view; without one the ideal lens whose circle fills the shorter side.
// Orientation  the calibration's; without one that of `up`, `image_up` and `image_right`. Where
//              both exist, they may differ by 20 degrees (a camera levelled by eye).
// Throws       std::runtime_error, one line: calibration that cannot be read or is of another model
//              or size, axes that are unknown, missing or not perpendicular, orientations that
//              contradict each other.
FisheyeSetup MakeFisheyeSetup(const FisheyeEntry& entry, const std::filesystem::path& folder);

bool HasFisheyePictures(const Sequence& sequence);

// For an entry that no frame has a picture of: throws as MakeFisheyeSetup, but that nothing may
// state the orientation yet, as after `calibrate lens`.
void CheckUnusedFisheye(const FisheyeEntry& entry, const std::filesystem::path& folder);

}  // namespace pleinair
