#include "pipeline/internal/shadow_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace pleinair {
namespace {

// A tile is this share of the picture's width: large enough for a shadow's edge and both its
// sides, small against what a passing car covers.
constexpr int kTilesAcross = 16;

double Luminance(const glm::vec3& rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

// A clipped pixel is at least as bright as it says: surely lit where lit and shaded differ.
bool MayBeUsed(const Frame& frame, std::size_t pixel) {
  if (frame.unusable.Empty() || frame.unusable.pixels[pixel] == 0) return true;
  return !frame.clipped.Empty() && frame.clipped.pixels[pixel] != 0;
}

}  // namespace

std::vector<std::uint8_t> UsableTriangles(const Mesh& mesh, std::span<const std::string> regions) {
  if (mesh.Empty()) throw std::invalid_argument("mesh: expected triangles");
  std::vector<std::uint8_t> usable(mesh.triangles.size(), regions.empty() ? 1 : 0);
  for (const std::string& name : regions) {
    bool found = false;
    for (std::size_t i = 0; i < usable.size(); ++i) {
      if (mesh.group_names[mesh.triangle_group[i]] != name &&
          mesh.materials[mesh.triangle_material[i]].name != name) {
        continue;
      }
      usable[i] = 1;
      found = true;
    }
    if (!found) {
      throw std::invalid_argument("diffuse_regions: \"" + name +
                                  "\" is no group or material of the mesh");
    }
  }
  return usable;
}

ShadowPicture MakeShadowPicture(const Frame& frame, std::span<const ShadowPixel> surfaces) {
  ShadowPicture picture;
  const int tile_px = std::max(1, frame.radiance.width / kTilesAcross);
  for (const ShadowPixel& surface : surfaces) {
    const std::size_t i = frame.radiance.Index(surface.x, surface.y);
    const double luminance = Luminance(frame.radiance.pixels[i]);
    if (!MayBeUsed(frame, i) || !(luminance > 0.0) || !std::isfinite(luminance)) continue;
    picture.surface.push_back(surface);
    picture.log_radiance.push_back(std::log(luminance));
    const glm::vec3& rgb = frame.radiance.pixels[i];
    const bool has_colour =
        rgb.x > 0.0f && rgb.z > 0.0f && (frame.clipped.Empty() || frame.clipped.pixels[i] == 0);
    picture.log_blue_over_red.push_back(has_colour ? std::log(double{rgb.z} / rgb.x)
                                                   : std::numeric_limits<double>::quiet_NaN());
    picture.plane.push_back(surface.plane);
    picture.tile.push_back(
        static_cast<std::uint32_t>(1000 * (surface.y / tile_px) + surface.x / tile_px));
  }
  return picture;
}

}  // namespace pleinair
