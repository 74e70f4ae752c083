// A fish-eye camera in the world: lens, orientation, and per-pixel tables for what is done with
// every picture.
#pragma once

#include <optional>
#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "calib/fisheye_lens.h"
#include "scene/image.h"

namespace pleinair {

struct FisheyeCamera {
  FisheyeIntrinsics intrinsics;
  // Its columns are the world (ENU) directions of the picture's right, the picture's down and the
  // optical axis. Orthogonal; its determinant is -1 where the picture is mirrored: a sky picture
  // with north at the top and east at the right is ("as a map"), one with east at the left is not.
  glm::dmat3 world_from_camera{1.0};

  bool IsMirrored() const { return glm::determinant(world_from_camera) < 0.0; }
};

// The unit world direction that words name: "+Y", "+Y north", "-X (west)", "south", "up". None for
// anything else, or where axis and word contradict each other.
std::optional<glm::dvec3> WorldAxisFromText(std::string_view text);

// world_from_camera for an optical axis, a picture's up and a picture's right that are given as
// world directions; none where two of them are not perpendicular (to 1e-6).
std::optional<glm::dmat3> FisheyeOrientationFromAxes(const glm::dvec3& axis_world,
                                                     const glm::dvec3& image_up_world,
                                                     const glm::dvec3& image_right_world);

// What each pixel sees. Row-major like the picture; where the pixel's centre is outside the lens's
// validity, direction and solid angle are 0.
struct FisheyePixelTable {
  Image<glm::vec3> direction_world;  // Unit.
  Image<float> solid_angle_sr;
};

// Cost    0.2 us a pixel (equidistant) to 0.8 us (opencv): once a camera. Throws as FisheyeLens.
FisheyePixelTable MakeFisheyePixelTable(const FisheyeCamera& camera);

}  // namespace pleinair
