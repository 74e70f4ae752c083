#include "datasets/fisheye_setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "calib/fisheye_file.h"
#include "datasets/internal/sequence_folder.h"
#include "scene/angle_between.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr double kRoughOrientationRad = RadFromDeg(20.0);

struct StatedAxis {
  const char* key;
  const std::string& text;
  // The column of world_from_camera that it gives, and its sign there.
  int column;
  double sign;
};

std::array<StatedAxis, 3> StatedAxes(const FisheyeEntry& entry) {
  return {{{"up", entry.up, 2, 1.0},
           {"image_up", entry.image_up, 1, -1.0},
           {"image_right", entry.image_right, 0, 1.0}}};
}

glm::dvec3 ParseAxis(const StatedAxis& axis) {
  const auto direction = WorldAxisFromText(axis.text);
  if (direction) return *direction;
  throw std::runtime_error(std::string(axis.key) +
                           ": expected a world axis such as \"+Y north\", found \"" + axis.text +
                           "\"");
}

glm::dmat3 OrientationOf(const FisheyeEntry& entry, const std::optional<glm::dmat3>& calibrated) {
  glm::dmat3 stated(0.0);
  for (const StatedAxis& axis : StatedAxes(entry)) {
    if (axis.text.empty()) {
      if (calibrated) continue;
      throw std::runtime_error(std::string(axis.key) +
                               ": expected a world axis such as \"+Y north\", as no calibration "
                               "states the orientation");
    }
    const glm::dvec3 direction = ParseAxis(axis);
    stated[axis.column] = axis.sign * direction;
    if (!calibrated) continue;
    const glm::dvec3 found = axis.sign * (*calibrated)[axis.column];
    const double apart_rad = AngleBetweenRad(found, direction);
    if (!(apart_rad <= kRoughOrientationRad)) {
      throw std::runtime_error(std::string(axis.key) + ": expected what the calibration says to " +
                               std::to_string(static_cast<int>(DegFromRad(kRoughOrientationRad))) +
                               " degrees, found \"" + axis.text + "\", " +
                               std::to_string(static_cast<int>(DegFromRad(apart_rad))) +
                               " degrees from it");
    }
  }
  if (calibrated) return *calibrated;
  const auto orientation = FisheyeOrientationFromAxes(stated[2], -stated[1], stated[0]);
  if (orientation) return *orientation;
  throw std::runtime_error(
      "up, image_up and image_right: expected axes perpendicular to each other, of a picture that "
      "is not mirrored (of the sky, with north at the top, east is left), found \"" +
      entry.up + "\", \"" + entry.image_up + "\", \"" + entry.image_right + "\"");
}

// All but the orientation, which is that of the calibration where it has one.
struct LensSetup {
  FisheyeIntrinsics intrinsics;
  std::optional<glm::dmat3> world_from_camera;
  std::optional<glm::dmat3> room_from_fisheye_rgb;
};

LensSetup LensOf(const FisheyeEntry& entry, const std::filesystem::path& folder) {
  const auto model = FisheyeModelFromName(entry.model);
  if (!model) throw std::runtime_error("model: expected a fish-eye model, found " + entry.model);
  LensSetup setup;
  if (entry.calibration) {
    const auto file = ResolveInside(folder, *entry.calibration);
    if (!file) throw std::runtime_error("calibration: expected " + file.error());
    const FisheyeCalibration calibration = ReadFisheyeCalibration(*file);
    setup.intrinsics = calibration.intrinsics;
    const FisheyeIntrinsics& lens = calibration.intrinsics;
    if (lens.model != *model || lens.width_px != entry.width_px ||
        lens.height_px != entry.height_px) {
      throw std::runtime_error(std::string("calibration: expected one of a lens ") + entry.model +
                               " " + std::to_string(entry.width_px) + "x" +
                               std::to_string(entry.height_px) + ", found " +
                               FisheyeModelName(lens.model) + " " + std::to_string(lens.width_px) +
                               "x" + std::to_string(lens.height_px));
    }
    setup.intrinsics.max_angle_rad = 0.5 * RadFromDeg(entry.fov_deg);
    setup.world_from_camera = calibration.world_from_camera;
    setup.room_from_fisheye_rgb = calibration.room_from_fisheye_rgb;
  } else if (*model == FisheyeModel::kOpenCv) {
    throw std::runtime_error("calibration: expected a file, as the model is opencv");
  } else {
    setup.intrinsics =
        CentredFisheye(*model, RadFromDeg(entry.fov_deg), entry.width_px, entry.height_px);
  }
  return setup;
}

}  // namespace

FisheyeSetup MakeFisheyeSetup(const FisheyeEntry& entry, const std::filesystem::path& folder) {
  const LensSetup lens = LensOf(entry, folder);
  return {{lens.intrinsics, OrientationOf(entry, lens.world_from_camera)},
          lens.room_from_fisheye_rgb};
}

bool HasFisheyePictures(const Sequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(), [](const FrameEntry& frame) {
    return frame.fisheye.has_value();
  });
}

void CheckUnusedFisheye(const FisheyeEntry& entry, const std::filesystem::path& folder) {
  const LensSetup lens = LensOf(entry, folder);
  const auto axes = StatedAxes(entry);
  const bool states_axes = std::any_of(
      axes.begin(), axes.end(), [](const StatedAxis& axis) { return !axis.text.empty(); });
  if (lens.world_from_camera || states_axes) OrientationOf(entry, lens.world_from_camera);
}

}  // namespace pleinair
