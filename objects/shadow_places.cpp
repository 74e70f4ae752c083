#include "objects/shadow_places.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "calib/lens.h"

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

// Pixels of a view by the places that they show.
class PixelOfPlace {
 public:
  explicit PixelOfPlace(const SurfaceView& view)
      : view_(view), lens_(view.camera.intrinsics), eye_m_(view.camera.CentreWorldM()) {}

  std::int32_t operator()(const glm::vec3& place_m) const {
    const glm::dvec3 in_camera(view_.camera.camera_from_world *
                               glm::dvec4(glm::dvec3(place_m), 1.0));
    if (!(in_camera.z > 0.0)) return ShadowPlaces::kNotSeen;
    const std::optional<glm::dvec2> at = lens_.ProjectToPixel(in_camera);
    if (!at) return ShadowPlaces::kNotSeen;
    const auto x = static_cast<int>(std::lround(at->x));
    const auto y = static_cast<int>(std::lround(at->y));
    if (x < 0 || y < 0 || x >= view_.Width() || y >= view_.Height()) return ShadowPlaces::kNotSeen;
    const std::size_t pixel = view_.region.Index(x, y);
    if (view_.region.pixels[pixel] == SurfaceView::kNoRegion) return ShadowPlaces::kNotSeen;
    // Something else may stand before it. Both lie in one pixel, up to its diagonal on a surface
    // that is seen at an angle.
    const glm::vec3& seen_m = view_.position_world_m.pixels[pixel];
    const glm::dvec3 ray = glm::dvec3(seen_m) - eye_m_;
    const double distance_m = glm::length(ray);
    const double cosine =
        std::abs(glm::dot(glm::dvec3(view_.normal_world.pixels[pixel]), ray)) / distance_m;
    const double pixel_m = distance_m / lens_.Intrinsics().fx_px / std::max(cosine, kLeastCosine);
    if (glm::distance(seen_m, place_m) > static_cast<float>(pixel_m) + kNearM) {
      return ShadowPlaces::kNotSeen;
    }
    return static_cast<std::int32_t>(pixel);
  }

 private:
  static constexpr double kLeastCosine = 0.02;
  static constexpr float kNearM = 0.01f;

  const SurfaceView& view_;
  Lens lens_;
  glm::dvec3 eye_m_;
};

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
      places.pixel.At(columns[ray], y) = pixel_of(origins_m[ray] - hits[ray].distance_m * to_sun);
    }
  });
  return places;
}

}  // namespace pleinair
