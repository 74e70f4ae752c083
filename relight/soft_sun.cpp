#include "relight/soft_sun.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/internal/camera_pixels.h"
#include "relight/internal/low_discrepancy.h"

namespace pleinair {
namespace {

constexpr int kSide = ObjectView::kSamplesPerSide;
constexpr int kSamplesPerPixel = kSide * kSide;
static_assert(kSide == ObjectSunShare::kSamplesPerSide);
// Probes of the rim, one for each of a pixel's samples.
static_assert(kSamplesPerPixel == 4);

// What the few points that all pixels ask for say of a pixel.
enum class Verdict : std::uint8_t { kNothing, kAllSeen, kAllHidden, kMixed };

// Whether shadow may have an edge in the pixel: where it or a neighbour is mixed, or disagrees.
bool IsNearEdge(const Image<Verdict>& verdicts, int x, int y) {
  const Verdict own = verdicts.At(x, y);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!verdicts.Contains(x + dx, y + dy)) continue;
      const Verdict other = verdicts.At(x + dx, y + dy);
      if (other == Verdict::kMixed) return true;
      if (other != Verdict::kNothing && other != own) return true;
    }
  }
  return false;
}

// Pixels of which a run is cast at a time: rays of neighbours are near each other.
constexpr std::size_t kRun = 256;

// Many rays towards the sun, past one caster and then another.
class ShadowRays {
 public:
  void Clear() {
    origins_m_.clear();
    directions_.clear();
    tags_.clear();
  }
  void Add(const glm::vec3& origin_m, const glm::vec3& direction, std::uint32_t tag) {
    origins_m_.push_back(origin_m);
    directions_.push_back(direction);
    tags_.push_back(tag);
  }
  std::size_t Count() const { return tags_.size(); }
  std::uint32_t Tag(std::size_t ray) const { return tags_[ray]; }

  // Leaves those that `caster` does not stop.
  void PassBy(const RayCaster& caster) {
    const auto occluded = std::make_unique<bool[]>(Count());
    caster.Occluded(origins_m_.data(), directions_.data(), Count(), occluded.get());
    std::size_t kept = 0;
    for (std::size_t ray = 0; ray < tags_.size(); ++ray) {
      if (occluded[ray]) continue;
      origins_m_[kept] = origins_m_[ray];
      directions_[kept] = directions_[ray];
      tags_[kept] = tags_[ray];
      ++kept;
    }
    origins_m_.resize(kept);
    directions_.resize(kept);
    tags_.resize(kept);
  }

 private:
  std::vector<glm::vec3> origins_m_;
  std::vector<glm::vec3> directions_;
  std::vector<std::uint32_t> tags_;
};

}  // namespace

void SoftSunOptions::Validate() const {
  if (disc_samples >= kSamplesPerPixel) return;
  throw std::invalid_argument(std::string("SoftSunOptions::disc_samples is ") +
                              std::to_string(disc_samples) + ": expected at least " +
                              std::to_string(kSamplesPerPixel));
}

// Directions to points of the disc.
class SoftSun::Disc {
 public:
  Disc(const DirectionalLight& sun, int samples) {
    const double length = glm::length(sun.direction_enu);
    if (!(length > 0.0) || !std::isfinite(length)) {
      throw std::invalid_argument("soft sun: the sun's direction has length " +
                                  std::to_string(length) + ", expected a unit vector");
    }
    if (!(sun.angular_radius_rad >= 0.0) || !(sun.angular_radius_rad < 0.5 * std::numbers::pi)) {
      throw std::invalid_argument("soft sun: angular_radius_rad is " +
                                  std::to_string(sun.angular_radius_rad) + ": expected [0, pi/2)");
    }
    const glm::dvec3 centre = sun.direction_enu / length;
    const NormalFrame frame{glm::vec3(centre)};
    const double tangent_radius = std::tan(sun.angular_radius_rad);
    const auto direction = [&](double radius, double angle) {
      return glm::vec3(
          glm::normalize(centre + radius * tangent_radius *
                                      (std::cos(angle) * glm::dvec3(frame.tangent) +
                                       std::sin(angle) * glm::dvec3(frame.bitangent))));
    };
    centre_ = glm::vec3(centre);
    // What stands upright is narrow across the level axis; with the sun in the zenith any will do.
    const glm::dvec3 level(centre.y, -centre.x, 0.0);
    level_ = glm::length(level) > 1e-6 ? glm::vec3(glm::normalize(level)) : frame.tangent;
    upright_ = glm::cross(centre_, level_);
    tangent_radius_ = static_cast<float>(tangent_radius);
    for (std::size_t i = 0; i < rim_.size(); ++i) {
      rim_[i] = direction(1.0, 0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5));
    }
    // Vogel's sunflower: equal areas, no two points on one straight edge. Of the places in a pixel
    // that go with them the same holds.
    for (int i = 0; i < samples; ++i) {
      points_.push_back(direction(std::sqrt((i + 0.5) / samples),
                                  2.0 * std::numbers::pi * i * (std::numbers::phi - 1.0)));
      places_.push_back(R2Point(i, glm::dvec2(0.5)) - 0.5);
    }
    // A sunflower for each of a pixel's samples, turned and set off against the others'.
    const int per_sample = (samples + kSamplesPerPixel - 1) / kSamplesPerPixel;
    for (int corner = 0; corner < kSamplesPerPixel; ++corner) {
      for (int i = 0; i < per_sample; ++i) {
        const double rank = i + (corner + 0.5) / kSamplesPerPixel;
        const double turns = (i + 0.4 * corner) * (std::numbers::phi - 1.0);
        points_of_sample_[static_cast<std::size_t>(corner)].push_back(
            direction(std::sqrt(rank / per_sample), 2.0 * std::numbers::pi * turns));
      }
    }
  }

  const glm::vec3& Centre() const { return centre_; }
  // Coordinates across the beam, the first of them level, and towards the sun.
  glm::vec3 InBeam(const glm::vec3& position_m) const {
    return {glm::dot(position_m, level_),
            glm::dot(position_m, upright_),
            glm::dot(position_m, centre_)};
  }
  float TangentRadius() const { return tangent_radius_; }
  const std::array<glm::vec3, 4>& Rim() const { return rim_; }
  const std::vector<glm::vec3>& Points() const { return points_; }
  // In a pixel's square, from its centre.
  const std::vector<glm::dvec2>& Places() const { return places_; }
  const std::vector<glm::vec3>& PointsOfSample(int corner) const {
    return points_of_sample_[static_cast<std::size_t>(corner)];
  }

 private:
  glm::vec3 centre_{0.0f};
  glm::vec3 level_{0.0f};
  glm::vec3 upright_{0.0f};
  float tangent_radius_ = 0.0f;
  std::array<glm::vec3, 4> rim_;
  std::vector<glm::vec3> points_;
  std::vector<glm::dvec2> places_;
  std::array<std::vector<glm::vec3>, kSamplesPerPixel> points_of_sample_;
};

namespace {

// Of each pixel, by the disc's centre and rim past `objects`.
template <class Disc>
std::vector<Verdict> VerdictsOf(const SurfaceView& view,
                                std::span<const std::uint32_t> pixels,
                                const Disc& disc,
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
      const std::size_t count = seen[i - run * kRun];
      verdicts[i] = count == 0                       ? Verdict::kAllHidden
                    : count == 1 + disc.Rim().size() ? Verdict::kAllSeen
                                                     : Verdict::kMixed;
    }
  });
  return verdicts;
}

}  // namespace

SoftSun::SoftSun(const RayCaster& real, const PatchScene& objects, const SoftSunOptions& options)
    : real_(real), objects_(objects), options_(options) {
  options_.Validate();
}

// Those that face the sun and from which some of the disc may lie behind an object: seen along the
// sun's direction, within the rectangle around the object, wider by what the disc spans from there.
std::vector<std::uint32_t> SoftSun::PixelsNearShadow(const SurfaceView& view,
                                                     const Disc& disc) const {
  const std::vector<Silhouette> silhouettes = SilhouettesFrom(disc);
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(view.Height()));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    const std::size_t first = view.region.Index(0, y);
    for (std::size_t pixel = first; pixel < first + static_cast<std::size_t>(view.Width());
         ++pixel) {
      const glm::vec3 at = disc.InBeam(view.position_world_m.pixels[pixel]);
      const bool is_near =
          std::any_of(silhouettes.begin(), silhouettes.end(), [&](const Silhouette& silhouette) {
            const float behind_m = silhouette.upper.z - at.z;
            const float margin_m = behind_m * disc.TangentRadius();
            return behind_m > 0.0f && at.x > silhouette.lower.x - margin_m &&
                   at.x < silhouette.upper.x + margin_m && at.y > silhouette.lower.y - margin_m &&
                   at.y < silhouette.upper.y + margin_m;
          });
      if (!is_near || view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
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
  return PixelsNearShadow(view, Disc(sun, options_.disc_samples));
}

std::vector<std::uint8_t> SoftSun::MayLoseSun(const SurfaceView& view,
                                              const DirectionalLight& sun,
                                              std::span<const std::uint32_t> pixels) const {
  const Disc disc(sun, options_.disc_samples);
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

std::vector<SoftSun::Silhouette> SoftSun::SilhouettesFrom(const Disc& disc) const {
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
                          const Disc& disc) const {
  const glm::vec3& position_m = view.position_world_m.pixels[pixel];
  const glm::vec3& normal = view.normal_world.pixels[pixel];
  const glm::dvec2 at(static_cast<double>(pixel % static_cast<std::size_t>(view.Width())),
                      static_cast<double>(pixel / static_cast<std::size_t>(view.Width())));
  const auto right_m = pixels.OnPlane(at + glm::dvec2(0.5, 0.0), position_m, normal);
  const auto below_m = pixels.OnPlane(at + glm::dvec2(0.0, 0.5), position_m, normal);
  const glm::vec3 dx = right_m ? 2.0f * (*right_m - position_m) : glm::vec3(0.0f);
  const glm::vec3 dy = below_m ? 2.0f * (*below_m - position_m) : glm::vec3(0.0f);
  const float real_share = view.sun_visibility.pixels[pixel];
  const bool in_real_penumbra = real_share > 0.0f && real_share < 1.0f;
  ShadowRays rays;
  for (std::size_t i = 0; i < disc.Points().size(); ++i) {
    const glm::vec3& direction = disc.Points()[i];
    if (!(glm::dot(direction, normal) > 0.0f)) continue;
    const glm::dvec2& place = disc.Places()[i];
    const glm::vec3 on_plane_m =
        position_m + static_cast<float>(place.x) * dx + static_cast<float>(place.y) * dy;
    rays.Add(OffsetFromSurface(on_plane_m, normal), direction, static_cast<std::uint32_t>(i));
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
  const Disc disc(sun, options_.disc_samples);
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

ObjectSunShare SoftSun::OnObjects(const ObjectView& view, const DirectionalLight& sun) const {
  ObjectSunShare share;
  if (view.Empty()) return share;
  const Disc disc(sun, options_.disc_samples);
  const int width = view.samples.width;
  const int height = view.samples.height;
  share.x_px = view.x_px;
  share.y_px = view.y_px;
  share.seen = GrayImage(width, height, 0.0f);

  struct Start {
    glm::vec3 origin_m{0.0f};
    glm::vec3 normal{0.0f};
  };
  const Mesh& mesh = objects_.mesh;
  const auto start_of = [&](const ObjectView::Sample& sample) -> std::optional<Start> {
    if (sample.triangle == ObjectView::kNothing) return std::nullopt;
    const glm::uvec3& corners = mesh.triangles[sample.triangle];
    const glm::vec3& a = mesh.positions_m[corners.x];
    const glm::vec3 position_m = a + sample.barycentric.x * (mesh.positions_m[corners.y] - a) +
                                 sample.barycentric.y * (mesh.positions_m[corners.z] - a);
    glm::vec3 normal = TriangleNormal(mesh, sample.triangle);
    if (glm::dot(normal, view.eye_m - position_m) < 0.0f) normal = -normal;
    if (!(glm::dot(normal, disc.Centre()) > -disc.TangentRadius())) return std::nullopt;
    return Start{OffsetFromSurface(position_m, normal), normal};
  };

  Gray8Image is_asked(width, height, 0);
  // Each of a pixel's samples asks for another point of the rim.
  Image<Verdict> verdicts(view.width_px, view.height_px, Verdict::kNothing);
  tbb::parallel_for(0, view.height_px, [&](int row) {
    ShadowRays rays;
    std::vector<std::uint8_t> asked(static_cast<std::size_t>(view.width_px), 0);
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(view.width_px), 0);
    for (int corner = 0; corner < kSamplesPerPixel; ++corner) {
      rays.Clear();
      for (int x = 0; x < view.width_px; ++x) {
        const int sample_x = kSide * x + corner % kSide;
        const int sample_y = kSide * row + corner / kSide;
        const auto start = start_of(view.samples.At(sample_x, sample_y));
        if (start && glm::dot(start->normal, disc.Centre()) > 0.0f) {
          is_asked.At(sample_x, sample_y) = 1;
        }
        const glm::vec3& direction = disc.Rim()[static_cast<std::size_t>(corner)];
        if (!start || !(glm::dot(start->normal, direction) > 0.0f)) continue;
        ++asked[static_cast<std::size_t>(x)];
        rays.Add(start->origin_m, direction, static_cast<std::uint32_t>(x));
      }
      rays.PassBy(objects_.caster);
      rays.PassBy(real_);
      for (std::size_t ray = 0; ray < rays.Count(); ++ray) ++seen[rays.Tag(ray)];
    }
    for (int x = 0; x < view.width_px; ++x) {
      const std::uint8_t count = asked[static_cast<std::size_t>(x)];
      if (count == 0) continue;
      const std::uint8_t of_them = seen[static_cast<std::size_t>(x)];
      verdicts.At(x, row) = of_them == 0       ? Verdict::kAllHidden
                            : of_them == count ? Verdict::kAllSeen
                                               : Verdict::kMixed;
    }
  });

  tbb::parallel_for(0, view.height_px, [&](int row) {
    ShadowRays rays;
    std::vector<int> seen(static_cast<std::size_t>(width * kSide), 0);
    std::vector<int> cast(seen.size(), 0);
    for (int x = 0; x < view.width_px; ++x) {
      const Verdict verdict = verdicts.At(x, row);
      if (verdict == Verdict::kNothing) continue;
      const bool near_edge = IsNearEdge(verdicts, x, row);
      if (!near_edge && verdict == Verdict::kAllHidden) continue;
      for (int corner = 0; corner < kSamplesPerPixel; ++corner) {
        const int sample_x = kSide * x + corner % kSide;
        const auto tag = static_cast<std::uint32_t>(corner / kSide * width + sample_x);
        const auto start = start_of(view.samples.At(sample_x, kSide * row + corner / kSide));
        if (!start) continue;
        for (const glm::vec3& direction : disc.PointsOfSample(corner)) {
          ++cast[tag];
          // Past its own plane a point of the disc is not seen.
          if (!(glm::dot(start->normal, direction) > 0.0f)) continue;
          if (near_edge) {
            rays.Add(start->origin_m, direction, tag);
          } else {
            ++seen[tag];
          }
        }
      }
    }
    rays.PassBy(objects_.caster);
    rays.PassBy(real_);
    for (std::size_t ray = 0; ray < rays.Count(); ++ray) ++seen[rays.Tag(ray)];
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (cast[i] == 0) continue;
      share.seen.pixels[static_cast<std::size_t>(kSide * row * width) + i] =
          static_cast<float>(seen[i]) / static_cast<float>(cast[i]);
    }
  });

  // Where nothing was asked.
  const GrayImage asked = share.seen;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (is_asked.At(x, y) != 0) continue;
      float sum = 0.0f;
      int count = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!is_asked.Contains(x + dx, y + dy) || is_asked.At(x + dx, y + dy) == 0) continue;
          sum += asked.At(x + dx, y + dy);
          ++count;
        }
      }
      if (count > 0) share.seen.At(x, y) = sum / static_cast<float>(count);
    }
  });
  return share;
}

}  // namespace pleinair
