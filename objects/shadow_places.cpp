#include "objects/shadow_places.h"

#include <cstdint>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "objects/internal/pixel_of_place.h"

namespace pleinair {
namespace {

struct Place {
  std::uint32_t triangle;
  glm::vec3 position_m;
};

// What the first of a pixel's samples shows that faces the sun: at an object's edge the others may
// show a face that is turned away.
std::optional<Place> PlaceFacing(
    const ObjectView& view, const Mesh& mesh, const glm::vec3& to_sun, int x, int y) {
  constexpr int kSide = ObjectView::kSamplesPerSide;
  for (int dy = 0; dy < kSide; ++dy) {
    for (int dx = 0; dx < kSide; ++dx) {
      const ObjectView::Sample& sample = view.samples.At(kSide * x + dx, kSide * y + dy);
      if (sample.triangle == ObjectView::kNothing) continue;
      const auto [position_m, normal] = PlaceOf(sample, mesh, view.eye_m);
      if (glm::dot(normal, to_sun) > 0.0f) return Place{sample.triangle, position_m};
    }
  }
  return std::nullopt;
}

}  // namespace

ShadowPlaces ShadowPlacesOf(const ObjectView& objects_in_view,
                            const PatchScene& objects,
                            const RayCaster& real,
                            const SurfaceView& view,
                            const glm::vec3& to_sun) {
  const int width = objects_in_view.width_px;
  const int height = objects_in_view.height_px;
  ShadowPlaces places{Image<std::int32_t>(width, height, ShadowPlaces::kNothing),
                      Image<std::uint32_t>(width, height, 0)};
  if (objects_in_view.Empty()) return places;
  const Mesh& mesh = objects.mesh;
  const PixelOfPlace pixel_of(view);
  tbb::parallel_for(0, height, [&](int y) {
    std::vector<int> columns;
    std::vector<glm::vec3> origins_m;
    columns.reserve(static_cast<std::size_t>(width));
    origins_m.reserve(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x) {
      const std::optional<Place> place = PlaceFacing(objects_in_view, mesh, to_sun, x, y);
      if (!place) continue;
      places.pixel.At(x, y) = ShadowPlaces::kNotSeen;
      places.object.At(x, y) = mesh.triangle_group[place->triangle];
      columns.push_back(x);
      origins_m.push_back(place->position_m);
    }
    const std::vector<glm::vec3> directions(origins_m.size(), -to_sun);
    std::vector<FaceHit> hits(origins_m.size());
    real.Intersect(origins_m.data(), directions.data(), origins_m.size(), hits.data());
    for (std::size_t ray = 0; ray < hits.size(); ++ray) {
      if (hits[ray].triangle == FaceHit::kNone) continue;
      places.pixel.At(columns[ray], y) =
          pixel_of(origins_m[ray] - hits[ray].distance_m * to_sun).value_or(ShadowPlaces::kNotSeen);
    }
  });
  return places;
}

}  // namespace pleinair
