#include "objects/mirror_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "objects/internal/face_count.h"
#include "objects/internal/ggx.h"
#include "objects/internal/pixel_of_place.h"
#include "relight/survey/survey_look_up.h"
#include "relight/transport/sun_disc.h"
#include "scene/low_discrepancy.h"
#include "scene/mean_beside.h"

namespace pleinair {
namespace {

constexpr int kViewSide = ObjectView::kSamplesPerSide;
// Places see one point of the disc each, in turn: pixels see many places.
constexpr int kMirroredDiscPoints = 16;

bool Mirrors(const Material& material) {
  const glm::vec3& k = material.specular_reflectance;
  return std::max({k.r, k.g, k.b}) > 0.0f;
}

// A glossy point as its sample shows it.
struct GlossyPoint {
  glm::vec3 start_m{0.0f};
  glm::vec3 to_viewer{0.0f};
  glm::vec3 normal{0.0f};  // Shading, to the viewer.
  glm::vec3 facing{0.0f};  // Of the triangle, to the viewer.
  const Material* material = nullptr;
};

std::optional<GlossyPoint> GlossyPointOf(const Mesh& mesh,
                                         const ObjectView::Sample& sample,
                                         const glm::vec3& eye_m) {
  if (sample.triangle == ObjectView::kNothing) return std::nullopt;
  const Material& material = mesh.materials[mesh.triangle_material[sample.triangle]];
  if (!Mirrors(material)) return std::nullopt;
  const glm::uvec3& corners = mesh.triangles[sample.triangle];
  const glm::vec2& b = sample.barycentric;
  const auto blend = [&](const std::vector<glm::vec3>& values) {
    return (1.0f - b.x - b.y) * values[corners.x] + b.x * values[corners.y] +
           b.y * values[corners.z];
  };
  GlossyPoint point;
  const glm::vec3 position_m = blend(mesh.positions_m);
  point.to_viewer = glm::normalize(eye_m - position_m);
  point.facing = TriangleNormal(mesh, sample.triangle);
  const bool from_behind = glm::dot(point.facing, point.to_viewer) < 0.0f;
  const glm::vec3 normal = blend(mesh.normals);
  const float length = glm::length(normal);
  point.normal = length > 0.0f ? normal / length : point.facing;
  if (from_behind) {
    point.facing = -point.facing;
    point.normal = -point.normal;
  }
  point.start_m = OffsetFromSurface(position_m, point.facing);
  point.material = &material;
  return point;
}

}  // namespace

void MirrorImageOptions::Validate() const {
  if (rays_per_pixel < 1) {
    throw std::invalid_argument("MirrorImageOptions::rays_per_pixel is " +
                                std::to_string(rays_per_pixel) + ": expected at least 1");
  }
  if (rays_per_place < 0) {
    throw std::invalid_argument("MirrorImageOptions::rays_per_place is " +
                                std::to_string(rays_per_place) + ": expected 0 or more");
  }
}

MirrorImage::MirrorImage(const PatchScene& real,
                         const PatchScene& objects,
                         const ObjectView& view,
                         const RealAppearance& appearance,
                         const MirrorImageOptions& options)
    : x_px_(view.x_px),
      y_px_(view.y_px),
      width_px_(view.width_px),
      height_px_(view.height_px),
      rays_per_place_(options.rays_per_place) {
  options.Validate();
  const auto pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  first_entry_.assign(pixels + 1, 0);
  if (view.Empty()) return;
  struct Row {
    std::vector<std::uint32_t> entry_count;
    std::vector<Entry> entries;  // Places and hiders count from the row's first.
    std::vector<Place> places;
    std::vector<std::int32_t> hiders;
  };
  std::vector<Row> rows(static_cast<std::size_t>(height_px_));
  const Mesh& mesh = objects.mesh;

  std::optional<PixelOfPlace> pixel_of;
  if (appearance.in_picture != nullptr) pixel_of.emplace(*appearance.in_picture);
  const auto add_place = [&](const RayHit& hit, const glm::vec3& direction, Row& row) {
    Place place;
    const std::int32_t side = PatchScene::SideOfHit(hit, direction);
    place.face = real.FaceOfSide(side);
    const glm::vec3 normal = real.SideNormal(static_cast<std::size_t>(side));
    place.start_m = OffsetFromSurface(hit.position_m, normal);
    if (appearance.survey != nullptr) {
      place.tint = appearance.survey->TintOf(real, side, hit.position_m);
    }
    if (pixel_of) place.pixel = (*pixel_of)(hit.position_m);
    place.first_hider = static_cast<std::uint32_t>(row.hiders.size());
    const NormalFrame frame(normal);
    const glm::dvec2 rotation = RotationOf(1, row.places.size());
    for (int ray = 0; ray < options.rays_per_place; ++ray) {
      const glm::vec3 up =
          frame.CosineDirection(FibonacciPoint(ray, options.rays_per_place, rotation));
      const auto hider = objects.caster.Intersect(place.start_m, up);
      if (!hider || real.caster.Occluded(place.start_m, up, hider->distance_m)) continue;
      row.hiders.push_back(objects.FaceOfHit(*hider, up));
      ++place.hider_count;
    }
    row.places.push_back(place);
    return static_cast<std::int32_t>(row.places.size() - 1);
  };

  // The same places in every pixel, and the same points of the lobe: what moves in the picture does
  // not crawl.
  std::vector<glm::dvec2> places;  // From a pixel's centre.
  places.reserve(static_cast<std::size_t>(options.rays_per_pixel));
  for (int ray = 0; ray < options.rays_per_pixel; ++ray) {
    places.push_back(
        FibonacciPoint(ray, options.rays_per_pixel, {0.0, 0.5 / options.rays_per_pixel}) - 0.5);
  }
  tbb::parallel_for(0, height_px_, [&](int y) {
    Row& row = rows[static_cast<std::size_t>(y)];
    std::vector<glm::dvec2> places_px;
    std::vector<ObjectView::Sample> at_places;
    for (int x = 0; x < width_px_; ++x) {
      std::vector<GlossyPoint> points;
      for (int corner = 0; corner < kViewSide * kViewSide; ++corner) {
        const auto point = GlossyPointOf(
            mesh,
            view.samples.At(kViewSide * x + corner % kViewSide, kViewSide * y + corner / kViewSide),
            view.eye_m);
        if (point) points.push_back(*point);
      }
      if (!points.empty()) {
        places_px.clear();
        for (const glm::dvec2& place : places) {
          places_px.push_back(glm::dvec2(view.x_px + x, view.y_px + y) + place);
        }
        SeeObjectsAt(view, objects, places_px, at_places);
      }
      const std::size_t before = row.entries.size();
      for (int ray = 0; ray < options.rays_per_pixel && !points.empty(); ++ray) {
        const auto rank = static_cast<std::size_t>(ray);
        // Beside the mirroring surface one of its samples is used instead.
        const GlossyPoint point =
            GlossyPointOf(mesh, at_places[rank], view.eye_m).value_or(points[rank % points.size()]);
        const float alpha = point.material->roughness * point.material->roughness;
        const auto mirrored = MirrorByGgx(point.normal,
                                          point.to_viewer,
                                          point.material->specular_reflectance,
                                          alpha,
                                          R2Point(ray, glm::dvec2(0.5)));
        if (!mirrored || !(glm::dot(mirrored->direction, point.facing) > 0.0f)) continue;
        Entry entry{mirrored->weight / static_cast<float>(options.rays_per_pixel),
                    mirrored->direction,
                    kSky};
        const auto on_real = real.caster.Intersect(point.start_m, entry.direction);
        const auto on_object =
            on_real ? objects.caster.Intersect(point.start_m, entry.direction, on_real->distance_m)
                    : objects.caster.Intersect(point.start_m, entry.direction);
        if (on_object) {
          entry.place = -2 - objects.FaceOfHit(*on_object, entry.direction);
        } else if (on_real) {
          entry.place = add_place(*on_real, entry.direction, row);
        } else if (!(entry.direction.z > 0.0f)) {
          continue;  // Past the ground's end, below the horizon: dark.
        }
        row.entries.push_back(entry);
      }
      row.entry_count.push_back(static_cast<std::uint32_t>(row.entries.size() - before));
    }
  });
  std::size_t pixel = 0;
  for (Row& row : rows) {
    const auto first_place = static_cast<std::int32_t>(places_.size());
    const auto first_hider = static_cast<std::uint32_t>(hiders_.size());
    for (const std::uint32_t count : row.entry_count) {
      first_entry_[pixel + 1] = first_entry_[pixel] + count;
      ++pixel;
    }
    for (Entry& entry : row.entries) {
      if (entry.place >= 0) entry.place += first_place;
      entries_.push_back(entry);
    }
    for (Place& place : row.places) {
      place.first_hider += first_hider;
      places_.push_back(place);
    }
    hiders_.insert(hiders_.end(), row.hiders.begin(), row.hiders.end());
  }
}

// Radiosity of a real surface at one place without the disc's own light there: the face's, scaled
// to the place's brightness, less what objects hide.
glm::vec3 MirrorImage::RadiosityAt(const Place& place, const LitScene& lit) const {
  const MirroredBasis& basis = lit.basis;
  const auto face = static_cast<std::size_t>(place.face);
  const glm::vec3& albedo = lit.real.face_albedo_rgb[face];
  glm::vec3 radiosity = basis.real_radiosity[face];
  if (!basis.real_direct.empty()) {
    radiosity = glm::max(radiosity - albedo * basis.real_direct[face], glm::vec3(0.0f));
  }
  if (place.hider_count > 0) {
    glm::vec3 from_hiders(0.0f);
    for (std::uint32_t i = 0; i < place.hider_count; ++i) {
      from_hiders +=
          basis.object_radiosity[static_cast<std::size_t>(hiders_[place.first_hider + i])];
    }
    const auto rays = static_cast<float>(rays_per_place_);
    radiosity *= 1.0f - static_cast<float>(place.hider_count) / rays;
    radiosity += albedo * from_hiders / rays;
  }
  return place.tint * radiosity;
}

glm::vec3 MirrorImage::DirectRadiosityAt(const Place& place,
                                         std::size_t index,
                                         const LitScene& lit) const {
  if (lit.basis.real_direct.empty()) return glm::vec3(0.0f);
  const auto face = static_cast<std::size_t>(place.face);
  const glm::vec3& direction = lit.to_sun[index % lit.to_sun.size()];
  const float cosine = glm::dot(lit.real.FaceNormal(face), direction);
  if (!(cosine > 0.0f) || !(direction.z > 0.0f) ||
      lit.objects.caster.Occluded(place.start_m, direction) ||
      lit.real.caster.Occluded(place.start_m, direction)) {
    return glm::vec3(0.0f);
  }
  return place.tint * lit.real.face_albedo_rgb[face] * cosine;
}

void MirrorImage::Fold(std::size_t light,
                       const MirroredBasis& basis,
                       const PatchScene& real,
                       const PatchScene& objects) {
  RequireFaceCount("mirror image: real_radiosity", basis.real_radiosity.size(), real.FaceCount());
  RequireFaceCount(
      "mirror image: object_radiosity", basis.object_radiosity.size(), objects.FaceCount());
  if (!basis.real_direct.empty()) {
    RequireFaceCount("mirror image: real_direct", basis.real_direct.size(), real.FaceCount());
  }
  if (Empty()) return;
  LitScene lit{basis, real, objects, {}};
  if (!basis.real_direct.empty()) {
    lit.to_sun = SunDisc(basis.sun.direction_enu, basis.sun.angular_radius_rad, kMirroredDiscPoints)
                     .Samples();
  }
  if (responses_.size() <= light) responses_.resize(light + 1);
  std::vector<glm::vec3>& response = responses_[light];
  response.assign(first_entry_.size() - 1, glm::vec3(0.0f));
  const bool is_sun = !basis.real_direct.empty();
  std::vector<std::vector<SunlitPlace>> sunlit(static_cast<std::size_t>(height_px_));
  tbb::parallel_for(0, height_px_, [&](int y) {
    for (int x = 0; x < width_px_; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_) +
                         static_cast<std::size_t>(x);
      glm::vec3 sum(0.0f);
      for (std::uint32_t i = first_entry_[pixel]; i < first_entry_[pixel + 1]; ++i) {
        const Entry& entry = entries_[i];
        if (entry.place == kSky) {
          if (basis.sky != nullptr) sum += entry.weight * basis.sky->Radiance(entry.direction);
          continue;
        }
        const glm::vec3 to_radiance = entry.weight * std::numbers::inv_pi_v<float>;
        if (entry.place < 0) {
          sum += to_radiance * basis.object_radiosity[static_cast<std::size_t>(-2 - entry.place)];
          continue;
        }
        const Place& place = places_[static_cast<std::size_t>(entry.place)];
        const glm::vec3 direct = to_radiance * DirectRadiosityAt(place, i, lit);
        sum += to_radiance * RadiosityAt(place, lit) + direct;
        if (is_sun && place.pixel && direct != glm::vec3(0.0f)) {
          std::vector<SunlitPlace>& of_row = sunlit[static_cast<std::size_t>(y)];
          // Rays of one pixel often meet what one pixel of the camera shows.
          if (!of_row.empty() && of_row.back().pixel == pixel &&
              of_row.back().in_picture == *place.pixel) {
            of_row.back().response += direct;
          } else {
            of_row.push_back({static_cast<std::uint32_t>(pixel), *place.pixel, direct});
          }
        }
      }
      response[pixel] = sum;
    }
  });
  if (!is_sun) return;
  sunlit_places_.clear();
  for (const std::vector<SunlitPlace>& of_row : sunlit) {
    sunlit_places_.insert(sunlit_places_.end(), of_row.begin(), of_row.end());
  }
  NumberSunlitPixels();
}

void MirrorImage::NumberSunlitPixels() {
  sunlit_pixels_.clear();
  for (const SunlitPlace& place : sunlit_places_) sunlit_pixels_.push_back(place.in_picture);
  std::sort(sunlit_pixels_.begin(), sunlit_pixels_.end());
  sunlit_pixels_.erase(std::unique(sunlit_pixels_.begin(), sunlit_pixels_.end()),
                       sunlit_pixels_.end());
  for (SunlitPlace& place : sunlit_places_) {
    const auto at =
        std::lower_bound(sunlit_pixels_.begin(), sunlit_pixels_.end(), place.in_picture);
    place.in_picture = static_cast<std::int32_t>(at - sunlit_pixels_.begin());
  }
}

void MirrorImage::Evaluate(const Lighting& lighting,
                           std::span<const std::uint8_t> is_in_shade,
                           MirroredLight& image) const {
  image.x_px = x_px_;
  image.y_px = y_px_;
  if (Empty()) {
    image.radiance = {};
    return;
  }
  if (responses_.size() != 1 + lighting.sky.size()) {
    throw std::invalid_argument("mirror image: lighting.sky has " +
                                std::to_string(lighting.sky.size()) + " shapes, expected the " +
                                std::to_string(responses_.empty() ? 0 : responses_.size() - 1) +
                                " that were folded");
  }
  if (!is_in_shade.empty() && is_in_shade.size() != sunlit_pixels_.size()) {
    throw std::invalid_argument("mirror image: is_in_shade has " +
                                std::to_string(is_in_shade.size()) + " values, expected " +
                                std::to_string(sunlit_pixels_.size()));
  }
  image.radiance.width = width_px_;
  image.radiance.height = height_px_;
  image.radiance.pixels.assign(first_entry_.size() - 1, glm::vec3(0.0f));
  for (std::size_t light = 0; light < responses_.size(); ++light) {
    const glm::vec3 intensity(light == 0 ? lighting.sun.irradiance_rgb
                                         : lighting.sky[light - 1].irradiance_rgb);
    if (intensity == glm::vec3(0.0f) || responses_[light].empty()) continue;
    for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
      image.radiance.pixels[i] += intensity * responses_[light][i];
    }
  }
  if (!is_in_shade.empty()) {
    const glm::vec3 sun(lighting.sun.irradiance_rgb);
    for (const SunlitPlace& place : sunlit_places_) {
      if (is_in_shade[static_cast<std::size_t>(place.in_picture)] == 0) continue;
      glm::vec3& radiance = image.radiance.pixels[place.pixel];
      radiance = glm::max(radiance - sun * place.response, glm::vec3(0.0f));
    }
  }
  // A renderer may place an edge a little differently: pixels beside take the mean of those that
  // mirror.
  const RgbImage mirrored = image.radiance;
  const auto has_rays = [&](int x, int y) {
    const std::size_t i = mirrored.Index(x, y);
    return first_entry_[i + 1] > first_entry_[i];
  };
  for (int y = 0; y < height_px_; ++y) {
    for (int x = 0; x < width_px_; ++x) {
      if (has_rays(x, y)) continue;
      if (const auto mean = MeanBeside(mirrored, x, y, has_rays)) image.radiance.At(x, y) = *mean;
    }
  }
}

}  // namespace pleinair
