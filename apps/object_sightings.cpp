#include "apps/object_sightings.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "scene/mesh.h"

namespace pleinair {
namespace {

BoundingBox BoxAround(const std::vector<VirtualObject>& objects) {
  BoundingBox box = BoundingBoxOf(objects.front().mesh);
  for (const VirtualObject& object : objects) {
    const BoundingBox other = BoundingBoxOf(object.mesh);
    box.lower_m = glm::min(box.lower_m, other.lower_m);
    box.upper_m = glm::max(box.upper_m, other.upper_m);
  }
  return box;
}

// The place of `box` in the picture, and what keeps it from being seen there.
std::string WhereShown(const Camera& camera, const BoundingBox& box) {
  const CameraIntrinsics& lens = camera.intrinsics;
  const auto in_picture = [&](const glm::vec3& at_m) {
    return ProjectToPixel(camera, glm::dvec3(at_m));
  };
  const auto middle = in_picture(0.5f * (box.lower_m + box.upper_m));
  if (!middle) return "behind the camera, or outside what its lens shows";
  const bool is_inside = middle->x >= 0.0 && middle->y >= 0.0 &&
                         middle->x < static_cast<double>(lens.width_px) &&
                         middle->y < static_cast<double>(lens.height_px);
  const std::string pixel = fmt::format("pixel ({:.0f}, {:.0f})", middle->x, middle->y);
  if (!is_inside) {
    return fmt::format("at {}, outside the picture of {}x{}", pixel, lens.width_px, lens.height_px);
  }
  double radius_px = 0.0;
  for (const glm::vec3& corner : CornersOf(box)) {
    if (const auto at = in_picture(corner)) {
      radius_px = std::max(radius_px, glm::distance(*at, *middle));
    }
  }
  const char* const reason =
      radius_px < 1.0 ? "smaller than a pixel" : "probably hidden by real surfaces";
  return fmt::format("at {}, {}", pixel, reason);
}

}  // namespace

void ObjectSightings::Add(const Camera& camera, const Composite& composite) {
  if (!first_camera_) first_camera_ = camera;
  if (is_any_seen_) return;
  const auto& change = composite.change.pixels;
  is_any_seen_ =
      std::ranges::find(change, static_cast<std::uint8_t>(PixelChange::kCovered)) != change.end();
}

std::optional<std::string> ObjectSightings::Note(const std::vector<VirtualObject>& objects) const {
  if (is_any_seen_ || !first_camera_ || objects.empty()) return std::nullopt;
  const BoundingBox box = BoxAround(objects);
  const glm::vec3 middle_m = 0.5f * (box.lower_m + box.upper_m);
  return fmt::format(
      "no frame shows any virtual object: at first they are around ({:.2f}, {:.2f}, {:.2f}) m, {} "
      "m "
      "high: {}; see `pleinair site place`",
      middle_m.x,
      middle_m.y,
      middle_m.z,
      fmt::format("{:.3g}", box.upper_m.z - box.lower_m.z),
      WhereShown(*first_camera_, box));
}

}  // namespace pleinair
