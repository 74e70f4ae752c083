// The file of a fish-eye camera, which `pleinair calibrate` writes and sequences name.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <glm/mat3x3.hpp>

#include "calib/fisheye_lens.h"

namespace pleinair {

// {"format": "pleinair-fisheye", "version": 1, "model": "opencv", "width": 1032, "height": 778,
//  "fx": 340.1, "fy": 340.2, "cx": 541.3, "cy": 377.0, "distortion": [k1, k2, k3, k4],
//  "fov_deg": 186.0, "orientation_world_from_camera": [[3] x 3], "room_from_fisheye_rgb": [[3] x
//  3], "rms_px": 0.31}
// Matrices are row-major; what is std::optional here may be absent there.
struct FisheyeCalibration {
  FisheyeIntrinsics intrinsics;                 // max_angle_rad is half of fov_deg.
  std::optional<glm::dmat3> world_from_camera;  // As FisheyeCamera's.
  // Converts radiance of the fish-eye camera to that of the room camera.
  std::optional<glm::dmat3> room_from_fisheye_rgb;
  std::optional<double> rms_px;  // Rms of the lens's fit, over the board corners.
};

// Reads such a file. world_from_camera must be orthogonal to 1e-5, and is then made exactly so.
// Throws std::runtime_error naming file, key and what was expected, also for a lens that
// FisheyeLens refuses.
FisheyeCalibration ReadFisheyeCalibration(const std::filesystem::path& file);

// Returns the file's text; angles are preserved to the last bit but one.
std::string FisheyeCalibrationText(const FisheyeCalibration& calibration);

}  // namespace pleinair
