#include "objects/soft_sun.h"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "objects/internal/disc_points.h"
#include "objects/internal/shadow_rays.h"
#include "relight/transport/camera_pixels.h"

namespace pleinair {
namespace {

// Pixels of which a run is cast at a time: rays of neighbours are near each other.
constexpr std::size_t kRun = 256;

// Verdict of each pixel, by rays to the disc's centre and rim past `objects`.
std::vector<Verdict> VerdictsOf(const SurfaceView& view,
                                std::span<const std::uint32_t> pixels,
                                const DiscPoints& disc,
                                const RayCaster& objects) {
  std::vector<Verdict> verdicts(pixels.size(), Verdict::kNothing);
  const std::size_t runs = (pixels.size() + kRun - 1) / kRun;
  tbb::parallel_for(std::size_t{0}, runs, [&](std::size_t run) {
    const std::size_t end = std::min(pixels.size(), (run + 1) * kRun);
    ShadowRays rays;
    std::array<std::uint8_t, kRun> seen{};
    for (std::size_t point = 0; point <= disc.Rim().size(); ++point) {
      const glm::vec3& direction = point == 0 ? disc.Centre() : disc.Rim()[point - 1];
      rays.Clear();
      for (std::size_t i = run * kRun; i < end; ++i) {
        const glm::vec3& normal = view.normal_world.pixels[pixels[i]];
        rays.Add(OffsetFromSurface(view.position_world_m.pixels[pixels[i]], normal),
                 direction,
                 static_cast<std::uint32_t>(i - run * kRun));
      }
      rays.PassBy(objects);
      for (std::size_t ray = 0; ray < rays.Count(); ++ray) ++seen[rays.Tag(ray)];
    }
    for (std::size_t i = run * kRun; i < end; ++i) {
      verdicts[i] = VerdictOf(seen[i - run * kRun], 1 + disc.Rim().size());
    }
  });
  return verdicts;
}

}  // namespace

void SoftSunOptions::Validate() const {
  if (disc_samples >= DiscPoints::kSamplesPerPixel) return;
  throw std::invalid_argument(std::string("SoftSunOptions::disc_samples is ") +
                              std::to_string(disc_samples) + ": expected at least " +
                              std::to_string(DiscPoints::kSamplesPerPixel));
}

SoftSun::SoftSun(const RayCaster& real, const PatchScene& objects, const SoftSunOptions& options)
    : real_(real), objects_(objects), options_(options) {
  options_.Validate();
}

// Seen along the sun's direction, places from which some of the disc may lie behind an object lie
// within the rectangle around it, widened by the disc's extent.
bool SoftSun::IsNear(std::span<const Silhouette> silhouettes,
                     const DiscPoints& disc,
                     const glm::vec3& position_m,
                     float reach_m) {
  const glm::vec3 at = disc.InBeam(position_m);
  return std::any_of(silhouettes.begin(), silhouettes.end(), [&](const Silhouette& silhouette) {
    const float behind_m = silhouette.upper.z - at.z + reach_m;
    const float margin_m = behind_m * disc.TangentRadius() + reach_m;
    return behind_m > 0.0f && at.x > silhouette.lower.x - margin_m &&
           at.x < silhouette.upper.x + margin_m && at.y > silhouette.lower.y - margin_m &&
           at.y < silhouette.upper.y + margin_m;
  });
}

std::function<bool(const glm::vec3&, float)> SoftSun::NearShadow(
    const DirectionalLight& sun) const {
  const DiscPoints disc(sun, options_.disc_samples);
  return [disc, silhouettes = SilhouettesFrom(disc)](const glm::vec3& point_m, float reach_m) {
    return IsNear(silhouettes, disc, point_m, reach_m);
  };
}

std::vector<std::uint32_t> SoftSun::PixelsNearShadow(const SurfaceView& view,
                                                     const DiscPoints& disc) const {
  const std::vector<Silhouette> silhouettes = SilhouettesFrom(disc);
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(view.Height()));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    const std::size_t first = view.region.Index(0, y);
    for (std::size_t pixel = first; pixel < first + static_cast<std::size_t>(view.Width());
         ++pixel) {
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion ||
          !IsNear(silhouettes, disc, view.position_world_m.pixels[pixel], 0.0f)) {
        continue;
      }
      if (!(glm::dot(view.normal_world.pixels[pixel], disc.Centre()) > 0.0f)) continue;
      rows[static_cast<std::size_t>(y)].push_back(static_cast<std::uint32_t>(pixel));
    }
  });
  std::vector<std::uint32_t> all;
  for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

std::vector<std::uint32_t> SoftSun::PixelsNearShadow(const SurfaceView& view,
                                                     const DirectionalLight& sun) const {
  return PixelsNearShadow(view, DiscPoints(sun, options_.disc_samples));
}

std::vector<std::uint8_t> SoftSun::MayLoseSun(const SurfaceView& view,
                                              const DirectionalLight& sun,
                                              std::span<const std::uint32_t> pixels) const {
  const DiscPoints disc(sun, options_.disc_samples);
  const auto for_neighbours = [&view](std::uint32_t pixel, const auto& visit) {
    const int x = static_cast<int>(pixel) % view.Width();
    const int y = static_cast<int>(pixel) / view.Width();
    for (int row = std::max(y - 1, 0); row <= std::min(y + 1, view.Height() - 1); ++row) {
      for (int column = std::max(x - 1, 0); column <= std::min(x + 1, view.Width() - 1); ++column) {
        visit(static_cast<std::uint32_t>(view.region.Index(column, row)));
      }
    }
  };
  enum : std::uint8_t { kNotAsked = 0, kAsked = 1, kHidden = 2 };
  Gray8Image state(view.Width(), view.Height(), kNotAsked);
  std::vector<std::uint32_t> asked;
  for (const std::uint32_t pixel : pixels) {
    for_neighbours(pixel, [&](std::uint32_t at) {
      if (state.pixels[at] != kNotAsked || view.region.pixels[at] == SurfaceView::kNoRegion ||
          !(glm::dot(view.normal_world.pixels[at], disc.Centre()) > 0.0f)) {
        return;
      }
      state.pixels[at] = kAsked;
      asked.push_back(at);
    });
  }
  const std::vector<Verdict> verdicts = VerdictsOf(view, asked, disc, objects_.caster);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (verdicts[i] != Verdict::kAllSeen) state.pixels[asked[i]] = kHidden;
  }
  std::vector<std::uint8_t> may_lose(pixels.size(), 0);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for_neighbours(pixels[i], [&](std::uint32_t at) {
      if (state.pixels[at] == kHidden) may_lose[i] = 1;
    });
  }
  return may_lose;
}

std::vector<SoftSun::Silhouette> SoftSun::SilhouettesFrom(const DiscPoints& disc) const {
  const Mesh& mesh = objects_.mesh;
  std::vector<std::optional<Silhouette>> of_group(mesh.group_names.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::optional<Silhouette>& silhouette = of_group.at(mesh.triangle_group.at(t));
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3 at = disc.InBeam(mesh.positions_m[mesh.triangles[t][corner]]);
      if (!silhouette) silhouette = Silhouette{at, at};
      silhouette->lower = glm::min(silhouette->lower, at);
      silhouette->upper = glm::max(silhouette->upper, at);
    }
  }
  std::vector<Silhouette> all;
  for (const std::optional<Silhouette>& silhouette : of_group) {
    if (silhouette) all.push_back(*silhouette);
  }
  return all;
}

// A mean over the pixel's square on its surface's plane and over the disc. Where real casters hide
// part of the disc, only what they leave counts: a product of two shares would be wrong where both
// hide the same part.
float SoftSun::HiddenOver(const SurfaceView& view,
                          const CameraPixels& pixels,
                          std::size_t pixel,
                          const DiscPoints& disc) const {
  const glm::vec3& position_m = view.position_world_m.pixels[pixel];
  const glm::vec3& normal = view.normal_world.pixels[pixel];
  const std::size_t row = pixel / static_cast<std::size_t>(view.Width());
  const glm::dvec2 at(static_cast<double>(pixel - row * static_cast<std::size_t>(view.Width())),
                      static_cast<double>(row));
  const auto right_m = pixels.OnPlane(at + glm::dvec2(0.5, 0.0), position_m, normal);
  const auto below_m = pixels.OnPlane(at + glm::dvec2(0.0, 0.5), position_m, normal);
  const glm::vec3 dx = right_m ? 2.0f * (*right_m - position_m) : glm::vec3(0.0f);
  const glm::vec3 dy = below_m ? 2.0f * (*below_m - position_m) : glm::vec3(0.0f);
  const float real_share = view.sun_visibility.pixels[pixel];
  const bool in_real_penumbra = real_share > 0.0f && real_share < 1.0f;
  ShadowRays rays;
  for (const DiscPoints::Point& point : disc.OfPixel()) {
    if (!(glm::dot(point.direction, normal) > 0.0f)) continue;
    const glm::vec3 on_plane_m = position_m + static_cast<float>(point.place.x) * dx +
                                 static_cast<float>(point.place.y) * dy;
    rays.Add(OffsetFromSurface(on_plane_m, normal), point.direction, 0);
  }
  std::size_t seen = rays.Count();
  if (in_real_penumbra) {
    ShadowRays past_real = rays;
    past_real.PassBy(real_);
    // Where the points say that there is no penumbra, objects decide alone.
    if (past_real.Count() > 0) {
      seen = past_real.Count();
      rays = std::move(past_real);
    }
  }
  if (seen == 0) return 0.0f;
  rays.PassBy(objects_.caster);
  return static_cast<float>(seen - rays.Count()) / static_cast<float>(seen);
}

RealSunShare SoftSun::OnReal(const SurfaceView& view, const DirectionalLight& sun) const {
  RealSunShare share;
  const DiscPoints disc(sun, options_.disc_samples);
  const std::vector<std::uint32_t> near = PixelsNearShadow(view, disc);
  if (near.empty()) return share;
  const int width = view.Width();
  glm::ivec2 lower(width, view.Height());
  glm::ivec2 upper(0);
  for (const std::uint32_t pixel : near) {
    const glm::ivec2 at(static_cast<int>(pixel) % width, static_cast<int>(pixel) / width);
    lower = glm::min(lower, at);
    upper = glm::max(upper, at + 1);
  }
  share.x_px = lower.x;
  share.y_px = lower.y;
  share.hidden = GrayImage(upper.x - lower.x, upper.y - lower.y, 0.0f);
  Image<Verdict> verdicts(share.hidden.width, share.hidden.height, Verdict::kNothing);

  const std::vector<Verdict> of_near = VerdictsOf(view, near, disc, objects_.caster);
  for (std::size_t i = 0; i < near.size(); ++i) {
    verdicts.At(static_cast<int>(near[i]) % width - lower.x,
                static_cast<int>(near[i]) / width - lower.y) = of_near[i];
  }
  const std::size_t runs = (near.size() + kRun - 1) / kRun;
  const CameraPixels pixels(view.camera);
  tbb::parallel_for(std::size_t{0}, runs, [&](std::size_t run) {
    for (std::size_t i = run * kRun; i < std::min(near.size(), (run + 1) * kRun); ++i) {
      const int x = static_cast<int>(near[i]) % width - lower.x;
      const int y = static_cast<int>(near[i]) / width - lower.y;
      share.hidden.At(x, y) = IsNearEdge(verdicts, x, y) ? HiddenOver(view, pixels, near[i], disc)
                              : verdicts.At(x, y) == Verdict::kAllHidden ? 1.0f
                                                                         : 0.0f;
    }
  });
  return share;
}

}  // namespace pleinair
