#include "pipeline/internal/shadow_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

// Mesh edges are trusted to this share of the picture's width: 3 pixels of 480. Coarse meshes of
// real buildings miss cornices by as much.
constexpr double kEdgeShareOfWidth = 1.0 / 160.0;
constexpr std::uint32_t kNoPlane = 0xffffffffu;
// States are cast only at each n-th candidate; between two that agree nothing changes.
constexpr int kCoarseStep = 4;
// Facings are distinguished to about 6 deg.
constexpr float kFacingSteps = 10.0f;

struct PlaneOfTriangle {
  std::vector<std::uint32_t> plane;  // By group, material, facing.
  std::vector<std::uint32_t> sheet;  // By distance from the origin too: where edges are.
};

PlaneOfTriangle NumberPlanes(const Mesh& mesh) {
  const BoundingBox box = BoundingBoxOf(mesh);
  const float sheet_m = 1e-3f * std::max(1.0f, glm::distance(box.lower_m, box.upper_m) * 0.01f);
  std::map<std::array<int, 5>, std::uint32_t> planes;
  std::map<std::array<int, 2>, std::uint32_t> sheets;
  PlaneOfTriangle result;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::vec3 normal = TriangleNormal(mesh, i);
    const auto plane = planes.try_emplace({static_cast<int>(mesh.triangle_group[i]),
                                           static_cast<int>(mesh.triangle_material[i]),
                                           static_cast<int>(std::lround(kFacingSteps * normal.x)),
                                           static_cast<int>(std::lround(kFacingSteps * normal.y)),
                                           static_cast<int>(std::lround(kFacingSteps * normal.z))},
                                          static_cast<std::uint32_t>(planes.size()));
    result.plane.push_back(plane.first->second);
    const float distance_m = glm::dot(normal, mesh.positions_m[mesh.triangles[i].x]);
    const auto sheet = sheets.try_emplace({static_cast<int>(plane.first->second),
                                           static_cast<int>(std::lround(distance_m / sheet_m))},
                                          static_cast<std::uint32_t>(sheets.size()));
    result.sheet.push_back(sheet.first->second);
  }
  return result;
}

// Whether all within `radius` pixels, the picture's border excluded, is the same sheet.
Gray8Image InsideSheets(const Image<std::uint32_t>& sheet, int radius) {
  const auto differs = [&](const Gray8Image& same, int dx, int dy) {
    Gray8Image result(sheet.width, sheet.height, 0);
    for (int y = radius * dy; y < sheet.height - radius * dy; ++y) {
      for (int x = radius * dx; x < sheet.width - radius * dx; ++x) {
        bool all = same.At(x, y) != 0;
        for (int k = -radius; k <= radius && all; ++k) {
          const int nx = x + k * dx;
          const int ny = y + k * dy;
          all = same.At(nx, ny) != 0 && sheet.At(nx, ny) == sheet.At(x, y);
        }
        result.At(x, y) = all ? 1 : 0;
      }
    }
    return result;
  };
  Gray8Image any(sheet.width, sheet.height, 0);
  for (std::size_t i = 0; i < any.pixels.size(); ++i) any.pixels[i] = sheet.pixels[i] != kNoPlane;
  return differs(differs(any, 1, 0), 0, 1);
}

}  // namespace

std::vector<ShadowPixel> FindShadowPixels(const UsableSurfaces& surfaces,
                                          const Camera& camera,
                                          int most,
                                          const std::stop_token& stop) {
  const PlaneOfTriangle planes = NumberPlanes(surfaces.mesh);
  const int width = camera.intrinsics.width_px;
  const int height = camera.intrinsics.height_px;
  const Lens lens(camera.intrinsics);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  const glm::vec3 centre_m(camera.CentreWorldM());
  Image<std::uint32_t> sheet(width, height, kNoPlane);
  std::vector<ShadowPixel> seen(sheet.pixels.size());
  for (int y = 0; y < height && !stop.stop_requested(); ++y) {
    for (int x = 0; x < width; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) continue;
      const glm::vec3 ray(glm::normalize(world_from_camera * *direction));
      const auto hit = surfaces.caster.Intersect(centre_m, ray);
      if (!hit) continue;
      const glm::vec3 normal = glm::dot(hit->geometric_normal, ray) > 0.0f ? -hit->geometric_normal
                                                                           : hit->geometric_normal;
      const std::size_t i = sheet.Index(x, y);
      sheet.pixels[i] = planes.sheet[hit->triangle];
      const bool may_be_used = surfaces.usable[hit->triangle] != 0;
      seen[i] = {x,
                 y,
                 may_be_used ? planes.plane[hit->triangle] : kNoPlane,
                 OffsetFromSurface(hit->position_m, normal),
                 normal};
    }
  }
  const int radius = std::max(1, static_cast<int>(std::lround(kEdgeShareOfWidth * width)));
  const Gray8Image inside = InsideSheets(sheet, radius);
  std::size_t count = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    count += inside.pixels[i] != 0 && seen[i].plane != kNoPlane;
  }
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(double(count) / most))));
  std::vector<ShadowPixel> result;
  for (int y = 0; y < height; y += stride) {
    for (int x = 0; x < width; x += stride) {
      const std::size_t i = sheet.Index(x, y);
      if (inside.pixels[i] != 0 && seen[i].plane != kNoPlane) result.push_back(seen[i]);
    }
  }
  return result;
}

std::vector<std::uint8_t> SharesOfSun(std::span<const ShadowPixel> pixels,
                                      const RayCaster& caster,
                                      const glm::dvec3& sun_direction_enu,
                                      const OffsetGrid& grid,
                                      const std::stop_token& stop) {
  const std::size_t candidates = grid.Size();
  std::vector<glm::vec3> suns;
  for (std::size_t k = 0; k < candidates; ++k) {
    suns.emplace_back(TurnedClockwise(sun_direction_enu, grid.OffsetRad(k)));
  }
  std::vector<std::uint8_t> shares(pixels.size() * candidates);
  tbb::parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    std::vector<std::uint8_t> lit(candidates);
    const auto cast = [&](std::size_t k) {
      lit[k] = glm::dot(pixels[i].normal, suns[k]) > 0.0f &&
               !caster.Occluded(pixels[i].start_m, suns[k]);
    };
    cast(0);
    for (std::size_t from = 0; from + 1 < candidates;) {
      const std::size_t to = std::min(from + kCoarseStep, candidates - 1);
      cast(to);
      for (std::size_t k = from + 1; k < to; ++k) {
        if (lit[from] == lit[to]) {
          lit[k] = lit[from];
        } else {
          cast(k);
        }
      }
      from = to;
    }
    std::uint8_t* share = &shares[i * candidates];
    for (std::size_t k = 0; k < candidates; ++k) {
      const std::size_t before = k > 0 ? k - 1 : k;
      const std::size_t after = std::min(k + 1, candidates - 1);
      share[k] = static_cast<std::uint8_t>(lit[before] + 2 * lit[k] + lit[after]);
    }
  });
  return shares;
}

std::vector<std::uint8_t> SharesOfSuns(std::span<const ShadowPixel> pixels,
                                       const RayCaster& caster,
                                       std::span<const glm::dvec3> suns,
                                       const std::stop_token& stop) {
  std::vector<std::uint8_t> shares(pixels.size() * suns.size());
  tbb::parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    for (std::size_t k = 0; k < suns.size(); ++k) {
      const glm::vec3 sun(suns[k]);
      const bool lit = sun.z > 0.0f && glm::dot(pixels[i].normal, sun) > 0.0f &&
                       !caster.Occluded(pixels[i].start_m, sun);
      shares[i * suns.size() + k] = lit ? 4 : 0;
    }
  });
  return shares;
}

}  // namespace pleinair
