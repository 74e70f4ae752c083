// The share of the disc that virtual objects see, over the parts of pixels; for real surfaces see
// soft_sun.cpp.

#include <cstdint>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "objects/internal/disc_points.h"
#include "objects/internal/shadow_rays.h"
#include "objects/soft_sun.h"
#include "scene/mean_beside.h"

namespace pleinair {
namespace {

constexpr int kSide = ObjectView::kSamplesPerSide;
static_assert(kSide == ObjectSunShare::kSamplesPerSide);

// Where a ray towards the disc leaves an object.
struct Start {
  glm::vec3 origin_m{0.0f};
  glm::vec3 normal{0.0f};

  // Past its tangent plane a point of the disc is not seen.
  bool Faces(const glm::vec3& direction) const { return glm::dot(normal, direction) > 0.0f; }
};

// None beside the objects, nor on faces from which nothing of the disc is seen.
std::optional<Start> StartOf(const ObjectView::Sample& sample,
                             const Mesh& mesh,
                             const glm::vec3& eye_m,
                             const DiscPoints& disc) {
  if (sample.triangle == ObjectView::kNothing) return std::nullopt;
  const auto [position_m, normal] = SmoothPlaceOf(sample, mesh, eye_m);
  if (!(glm::dot(normal, disc.Centre()) > -disc.TangentRadius())) return std::nullopt;
  return Start{OffsetFromSurface(position_m, normal), normal};
}

// What each of a pixel's samples sees of another point of the rim; `is_asked` becomes 1 for samples
// that are turned to the sun's centre.
Image<Verdict> VerdictsOn(const ObjectView& view,
                          const DiscPoints& disc,
                          const PatchScene& objects,
                          const RayCaster& real,
                          Gray8Image& is_asked) {
  Image<Verdict> verdicts(view.width_px, view.height_px, Verdict::kNothing);
  tbb::parallel_for(0, view.height_px, [&](int row) {
    ShadowRays rays;
    std::vector<std::uint8_t> asked(static_cast<std::size_t>(view.width_px), 0);
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(view.width_px), 0);
    for (int corner = 0; corner < DiscPoints::kSamplesPerPixel; ++corner) {
      rays.Clear();
      for (int x = 0; x < view.width_px; ++x) {
        const int sample_x = kSide * x + corner % kSide;
        const int sample_y = kSide * row + corner / kSide;
        const auto start =
            StartOf(view.samples.At(sample_x, sample_y), objects.mesh, view.eye_m, disc);
        if (start && start->Faces(disc.Centre())) is_asked.At(sample_x, sample_y) = 1;
        const glm::vec3& direction = disc.Rim()[static_cast<std::size_t>(corner)];
        if (!start || !start->Faces(direction)) continue;
        ++asked[static_cast<std::size_t>(x)];
        rays.Add(start->origin_m, direction, static_cast<std::uint32_t>(x));
      }
      rays.PassBy(objects.caster);
      rays.PassBy(real);
      for (std::size_t ray = 0; ray < rays.Count(); ++ray) ++seen[rays.Tag(ray)];
    }
    for (int x = 0; x < view.width_px; ++x) {
      const auto column = static_cast<std::size_t>(x);
      verdicts.At(x, row) = VerdictOf(seen[column], asked[column]);
    }
  });
  return verdicts;
}

// Samples that were not asked take their neighbours' mean.
void FillBeside(const Gray8Image& is_asked, GrayImage& seen) {
  const GrayImage asked = seen;
  tbb::parallel_for(0, seen.height, [&](int y) {
    for (int x = 0; x < seen.width; ++x) {
      if (is_asked.At(x, y) != 0) continue;
      const auto mean =
          MeanBeside(asked, x, y, [&](int u, int v) { return is_asked.At(u, v) != 0; });
      if (mean) seen.At(x, y) = *mean;
    }
  });
}

}  // namespace

ObjectSunShare SoftSun::OnObjects(const ObjectView& view, const DirectionalLight& sun) const {
  ObjectSunShare share;
  if (view.Empty()) return share;
  const DiscPoints disc(sun, options_.disc_samples);
  const Mesh& mesh = objects_.mesh;
  const int width = view.samples.width;
  share.x_px = view.x_px;
  share.y_px = view.y_px;
  share.seen = GrayImage(width, view.samples.height, 0.0f);
  Gray8Image is_asked(width, view.samples.height, 0);
  const Image<Verdict> verdicts = VerdictsOn(view, disc, objects_, real_, is_asked);

  tbb::parallel_for(0, view.height_px, [&](int row) {
    ShadowRays rays;
    std::vector<int> seen(static_cast<std::size_t>(width * kSide), 0);
    std::vector<int> cast(seen.size(), 0);
    // Near an edge each ray leaves from another place of the sample's part of the pixel.
    std::vector<std::uint32_t> near_edge;  // Samples of this row of pixels.
    std::vector<glm::dvec2> places_px;
    for (int x = 0; x < view.width_px; ++x) {
      const Verdict verdict = verdicts.At(x, row);
      if (verdict == Verdict::kNothing) continue;
      const bool is_near_edge = IsNearEdge(verdicts, x, row);
      if (!is_near_edge && verdict == Verdict::kAllHidden) continue;
      for (int corner = 0; corner < DiscPoints::kSamplesPerPixel; ++corner) {
        const auto tag =
            static_cast<std::uint32_t>(corner / kSide * width + kSide * x + corner % kSide);
        const ObjectView::Sample& sample =
            view.samples.pixels[view.samples.Index(0, kSide * row) + tag];
        const auto start = StartOf(sample, mesh, view.eye_m, disc);
        if (!start) continue;
        cast[tag] = static_cast<int>(disc.OfSample(corner).size());
        if (is_near_edge) {
          near_edge.push_back(tag);
          for (const DiscPoints::Point& point : disc.OfSample(corner)) {
            places_px.push_back(glm::dvec2(view.x_px + x, view.y_px + row) + point.place);
          }
          continue;
        }
        for (const DiscPoints::Point& point : disc.OfSample(corner)) {
          if (start->Faces(point.direction)) ++seen[tag];
        }
      }
    }
    std::vector<ObjectView::Sample> at_places;
    SeeObjectsAt(view, objects_, places_px, at_places);
    auto at_place = at_places.cbegin();
    for (const std::uint32_t tag : near_edge) {
      const int sample_x = static_cast<int>(tag) % width;
      const int corner = static_cast<int>(tag) / width * kSide + sample_x % kSide;
      const auto own = StartOf(
          view.samples.pixels[view.samples.Index(0, kSide * row) + tag], mesh, view.eye_m, disc);
      for (const DiscPoints::Point& point : disc.OfSample(corner)) {
        // Beside what the sun may shine on the sample itself stands in.
        const auto there = StartOf(*at_place++, mesh, view.eye_m, disc);
        const Start& start = there && there->Faces(disc.Centre()) ? *there : *own;
        if (start.Faces(point.direction)) rays.Add(start.origin_m, point.direction, tag);
      }
    }
    rays.PassBy(objects_.caster);
    rays.PassBy(real_);
    for (std::size_t ray = 0; ray < rays.Count(); ++ray) ++seen[rays.Tag(ray)];
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (cast[i] == 0) continue;
      share.seen.pixels[share.seen.Index(0, kSide * row) + i] =
          static_cast<float>(seen[i]) / static_cast<float>(cast[i]);
    }
  });
  FillBeside(is_asked, share.seen);
  return share;
}

}  // namespace pleinair
