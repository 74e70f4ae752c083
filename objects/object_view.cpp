#include "objects/object_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"

namespace pleinair {
namespace {

struct Extent {
  glm::ivec2 lower{0};
  glm::ivec2 upper{0};  // Past the last pixel.
};

// The pixels that the vertices' picture spans, with a margin of one; the entire picture where an
// object reaches behind the camera.
Extent ExtentOf(const Mesh& mesh, const Camera& camera, const CameraIntrinsics& picture) {
  const glm::ivec2 size(picture.width_px, picture.height_px);
  glm::dvec2 lower(std::numeric_limits<double>::infinity());
  glm::dvec2 upper(-std::numeric_limits<double>::infinity());
  bool any_before = false;
  bool any_behind = false;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position_m(mesh.positions_m[triangle[corner]]);
      const glm::dvec3 at(camera.camera_from_world * glm::dvec4(position_m, 1.0));
      // What is nearer than a thousandth of its distance off the axis lands far outside anyway.
      if (!(at.z > 1e-3 * std::max(std::abs(at.x), std::abs(at.y)))) {
        any_behind = true;
        continue;
      }
      any_before = true;
      const glm::dvec2 pixel(picture.fx_px * at.x / at.z + picture.cx_px,
                             picture.fy_px * at.y / at.z + picture.cy_px);
      lower = glm::min(lower, pixel);
      upper = glm::max(upper, pixel);
    }
  }
  if (!any_before) return {};
  if (any_behind) return {glm::ivec2(0), size};
  const glm::dvec2 last(size);
  return {glm::ivec2(glm::clamp(glm::floor(lower) - 1.0, glm::dvec2(0.0), last)),
          glm::ivec2(glm::clamp(glm::ceil(upper) + 2.0, glm::dvec2(0.0), last))};
}

}  // namespace

ObjectPlace PlaceOf(const ObjectView::Sample& sample, const Mesh& mesh, const glm::vec3& eye_m) {
  const glm::uvec3& corners = mesh.triangles[sample.triangle];
  const glm::vec3& a = mesh.positions_m[corners.x];
  const glm::vec3 position_m = a + sample.barycentric.x * (mesh.positions_m[corners.y] - a) +
                               sample.barycentric.y * (mesh.positions_m[corners.z] - a);
  const glm::vec3 normal = TriangleNormal(mesh, sample.triangle);
  return {position_m, glm::dot(normal, eye_m - position_m) < 0.0f ? -normal : normal};
}

ObjectPlace SmoothPlaceOf(const ObjectView::Sample& sample,
                          const Mesh& mesh,
                          const glm::vec3& eye_m) {
  ObjectPlace place = PlaceOf(sample, mesh, eye_m);
  const glm::uvec3& corners = mesh.triangles[sample.triangle];
  const float side =
      glm::dot(TriangleNormal(mesh, sample.triangle), place.normal) < 0.0f ? -1.0f : 1.0f;
  const glm::vec3 weights(1.0f - sample.barycentric.x - sample.barycentric.y,
                          sample.barycentric.x,
                          sample.barycentric.y);
  glm::vec3 normal(0.0f);
  glm::vec3 outwards_m(0.0f);
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec3 at_corner = side * mesh.normals[corners[corner]];
    const float below_m = glm::dot(at_corner, mesh.positions_m[corners[corner]] - place.position_m);
    outwards_m += weights[corner] * std::max(below_m, 0.0f) * at_corner;
    normal += weights[corner] * at_corner;
  }
  // A box with shared normals is no ball: its faces stay where they are, nearly.
  constexpr float kMostOfEdge = 0.1f;
  float longest_m = 0.0f;
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec3& next_m = mesh.positions_m[corners[(corner + 1) % 3]];
    longest_m = std::max(longest_m, glm::distance(mesh.positions_m[corners[corner]], next_m));
  }
  const float out_m = glm::length(outwards_m);
  if (out_m > kMostOfEdge * longest_m) outwards_m *= kMostOfEdge * longest_m / out_m;
  const float length = glm::length(normal);
  if (length > 0.0f) return {place.position_m + outwards_m, normal / length};
  return place;
}

ObjectView SeeObjects(const PatchScene& objects, const Camera& camera) {
  constexpr int kSide = ObjectView::kSamplesPerSide;
  const CameraIntrinsics picture =
      camera.intrinsics.HasDistortion() ? UndistortedCover(camera.intrinsics) : camera.intrinsics;
  const Extent extent = ExtentOf(objects.mesh, camera, picture);
  ObjectView view;
  view.eye_m = glm::vec3(camera.CentreWorldM());
  if (extent.upper.x <= extent.lower.x || extent.upper.y <= extent.lower.y) return view;
  view.x_px = extent.lower.x;
  view.y_px = extent.lower.y;
  view.width_px = extent.upper.x - extent.lower.x;
  view.height_px = extent.upper.y - extent.lower.y;
  view.samples = Image<ObjectView::Sample>(kSide * view.width_px, kSide * view.height_px);
  const glm::dmat3 picture_from_camera(glm::dvec3(picture.fx_px, 0.0, 0.0),
                                       glm::dvec3(0.0, picture.fy_px, 0.0),
                                       glm::dvec3(picture.cx_px, picture.cy_px, 1.0));
  view.world_from_picture =
      glm::transpose(glm::dmat3(camera.camera_from_world)) * glm::inverse(picture_from_camera);
  tbb::parallel_for(0, view.height_px, [&](int row) {
    // A row of pixels at once: its samples are near each other.
    std::vector<glm::dvec2> places_px;
    for (int y = kSide * row; y < kSide * (row + 1); ++y) {
      for (int x = 0; x < view.samples.width; ++x) {
        places_px.emplace_back(view.x_px + (x + 0.5) / kSide - 0.5,
                               view.y_px + (y + 0.5) / kSide - 0.5);
      }
    }
    std::vector<ObjectView::Sample> samples;
    SeeObjectsAt(view, objects, places_px, samples);
    std::copy(samples.begin(),
              samples.end(),
              view.samples.pixels.begin() +
                  static_cast<std::ptrdiff_t>(view.samples.Index(0, kSide * row)));
  });
  return view;
}

void SeeObjectsAt(const ObjectView& view,
                  const PatchScene& objects,
                  std::span<const glm::dvec2> places_px,
                  std::vector<ObjectView::Sample>& samples) {
  std::vector<glm::vec3> directions;
  directions.reserve(places_px.size());
  for (const glm::dvec2& place_px : places_px) {
    directions.emplace_back(glm::normalize(view.world_from_picture * glm::dvec3(place_px, 1.0)));
  }
  const std::vector<glm::vec3> origins(places_px.size(), view.eye_m);
  std::vector<std::optional<RayHit>> hits(places_px.size());
  objects.caster.Intersect(origins.data(), directions.data(), places_px.size(), hits.data());
  samples.assign(places_px.size(), {});
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i]) samples[i] = {hits[i]->triangle, hits[i]->barycentric};
  }
}

}  // namespace pleinair
