// Shares of a camera's view in the sun and not in the sun, by geometry only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "datasets/sequence.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// A frame is well posed where at least this share of its visible diffuse pixels is sunlit, and at
// least this share is not. Then sun and sky can be distinguished.
inline constexpr double kWellPosedShare = 0.03;

// Counts of one frame's pixels.
struct SunlitShare {
  int diffuse_pixels = 0;  // Visible, in the diffuse regions.
  double lit = 0.0;        // Part of these; the rest is shaded or turned away.
  bool IsWellPosed() const {
    return diffuse_pixels > 0 && lit >= kWellPosedShare && 1.0 - lit >= kWellPosedShare;
  }
};

// Casts rays through the pixels of a sequence's cameras against its mesh. A diffuse mask is used
// where it is over the picture and the camera is fixed.
class SunlitCounter {
 public:
  // `mesh` is the sequence's scene. Throws std::runtime_error where the diffuse mask cannot be
  // read.
  SunlitCounter(const Sequence& sequence, const Mesh& mesh);

  // Keeps the view until it is called for another camera.
  SunlitShare Count(const Camera& camera, const glm::dvec3& sun_direction_enu);

 private:
  void See(const Camera& camera);

  struct Seen {
    glm::vec3 start_m;  // Off the surface, on the camera's side.
    glm::vec3 normal;   // Unit, turned to the camera.
  };
  RayCaster caster_;
  std::vector<std::uint8_t> triangle_is_diffuse_;
  std::optional<Gray8Image> mask_;
  std::optional<Camera> camera_;
  std::vector<Seen> seen_;
};

// 1 where the pixel, or one beside it, shows a virtual object's material with specular reflectance.
// None where no object has such a material. `objects` and `phantom` are in world coordinates; parts
// behind the phantom are not visible.
std::optional<Gray8Image> SpecularPixels(const std::vector<Mesh>& objects,
                                         const RayCaster& phantom,
                                         const Camera& camera);

}  // namespace pleinair
