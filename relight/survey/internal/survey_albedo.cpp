#include "relight/survey/internal/survey_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "scene/lat_long.h"
#include "scene/lighting.h"

namespace pleinair {
namespace {

constexpr double kFewestRays = 16.0;  // See the header.
constexpr double kConverged = 1e-4;
constexpr int kMaxIterations = 30;
// A face's mean leaves out pixels this near to an edge, where it has others.
constexpr float kEdgeMarginPx = 1.5f;
// The mean also leaves out this share of its weight at either end: glass, shadow of what the mesh
// lacks.
constexpr double kTrimmedShare = 0.1;
// A surface's albedo may be this many scatters from its median.
constexpr double kScatters = 2.0;

// The map's pixels sorted by the face they show.
class PixelsOfFaces {
 public:
  PixelsOfFaces(const Image<std::int32_t>& face, std::size_t face_count) {
    begin_.assign(face_count + 1, 0);
    for (const std::int32_t f : face.pixels) {
      if (f != PatchScene::kSky) ++begin_[static_cast<std::size_t>(f) + 1];
    }
    for (std::size_t i = 0; i < face_count; ++i) begin_[i + 1] += begin_[i];
    pixels_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < face.pixels.size(); ++i) {
      if (face.pixels[i] == PatchScene::kSky) continue;
      pixels_[next[static_cast<std::size_t>(face.pixels[i])]++] = static_cast<std::uint32_t>(i);
    }
  }
  std::span<const std::uint32_t> Of(std::size_t face) const {
    return {pixels_.data() + begin_[face], begin_[face + 1] - begin_[face]};
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> pixels_;
};

struct FaceMean {
  glm::vec3 albedo{0.0f};
  bool known = false;
};

// Mean of the face's measured pixels by solid angle, trimmed in brightness; of those away from
// edges, and from where shadows may have one, if there are any.
FaceMean MeanAlbedo(std::span<const std::uint32_t> pixels,
                    const Image<ShadowSide>& side,
                    const SurfaceView& view) {
  struct Sample {
    glm::vec3 albedo;
    double weight;
  };
  std::vector<Sample> samples;
  for (const auto& [margin, certain] :
       {std::pair{kEdgeMarginPx, true}, {kEdgeMarginPx, false}, {-1.0f, false}}) {
    for (const std::uint32_t pixel : pixels) {
      if (view.albedo_measured.pixels[pixel] == 0) continue;
      if (view.edge_distance_px.pixels[pixel] < margin) continue;
      if (certain && side.pixels[pixel] == ShadowSide::kUnsure) continue;
      const int row = static_cast<int>(pixel) / view.Width();
      samples.push_back({view.albedo_rgb.pixels[pixel],
                         LatLongPixelSolidAngleSr(row, {view.Width(), view.Height()})});
    }
    if (!samples.empty()) break;
  }
  if (samples.empty()) return {};
  std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return MeanOf(a.albedo) < MeanOf(b.albedo);
  });
  double whole = 0.0;
  for (const Sample& sample : samples) whole += sample.weight;
  // Each sample counts with the part of its weight between the two cuts, so that a face of one
  // pixel is that pixel.
  const double low = kTrimmedShare * whole;
  const double high = (1.0 - kTrimmedShare) * whole;
  glm::dvec3 sum(0.0);
  double below = 0.0;
  for (const Sample& sample : samples) {
    const double inside = std::min(below + sample.weight, high) - std::max(below, low);
    if (inside > 0.0) sum += inside * glm::dvec3(sample.albedo);
    below += sample.weight;
  }
  return {glm::vec3(sum / (high - low)), true};
}

class AlbedoSolver {
 public:
  AlbedoSolver(const AlbedoInput& input, PatchScene& scene, SurfaceView& view)
      : input_(input),
        scene_(scene),
        view_(view),
        pixels_(input.face, scene.FaceCount()),
        shape_(OwnSkyShape(input.light, input.skyline)),
        sun_(input.light.sun_irradiance_rgb),
        sky_(input.light.sky_irradiance_rgb),
        sun_relative_stddev_(glm::length(input.light.sun_irradiance_stddev_rgb) /
                             std::max(glm::length(input.light.sun_irradiance_rgb), 1e-300)),
        least_known_(static_cast<float>(kFewestRays / input.gather.Rays().RaysPerReceiver()) *
                     sky_) {
    view_.sun_direction_enu = input.light.sun_direction_enu;
    view_.albedo_rgb = RgbImage(view.Width(), view.Height(), glm::vec3(0.0f));
    view_.albedo_measured = Gray8Image(view.Width(), view.Height(), 0);
    view_.sky_response.assign(1, RgbImage(view.Width(), view.Height()));
    view_.sun_bounce = RgbImage(view.Width(), view.Height());
    face_sky_ = input.transport.DirectFromSky(*shape_);
    face_sun_ = input.transport.DirectFromSun(
        scene, input.light.sun_direction_enu, input.sun_angular_radius_rad);
    receiver_sky_ = input.gather.Rays().FromSky(*shape_);
  }

  AlbedoResult Solve() {
    AlbedoResult result;
    while (true) {
      // Both lights at once while iterating; apart, for the responses, at the end.
      std::vector<glm::vec3> face_direct(face_sky_.size());
      for (std::size_t i = 0; i < face_direct.size(); ++i) {
        face_direct[i] = sky_ * face_sky_[i] + sun_ * face_sun_[i];
      }
      const FaceLight faces = input_.transport.Solve(scene_, face_direct, input_.bounces);
      std::vector<glm::vec3> at_receivers = input_.gather.Rays().FromFaces(faces.radiosity);
      for (std::size_t i = 0; i < at_receivers.size(); ++i) {
        at_receivers[i] += sky_ * receiver_sky_[i];
      }
      input_.gather.Blend(at_receivers, view_.sky_response[0].pixels);
      std::fill(view_.sun_bounce.pixels.begin(), view_.sun_bounce.pixels.end(), glm::vec3(0.0f));
      AlbedoOfPixels(glm::vec3(1.0f));
      ++result.iterations;
      result.last_change = UpdateFaces();
      if (result.last_change < kConverged || result.iterations == kMaxIterations) break;
    }
    const FaceLight of_sky = input_.transport.Solve(scene_, face_sky_, input_.bounces);
    std::vector<glm::vec3> at_receivers = input_.gather.Rays().FromFaces(of_sky.radiosity);
    for (std::size_t i = 0; i < at_receivers.size(); ++i) at_receivers[i] += receiver_sky_[i];
    input_.gather.Blend(at_receivers, view_.sky_response[0].pixels);
    const FaceLight of_sun = input_.transport.Solve(scene_, face_sun_, input_.bounces);
    input_.gather.Blend(input_.gather.Rays().FromFaces(of_sun.radiosity), view_.sun_bounce.pixels);
    AlbedoOfPixels(sky_);
    result.on_wrong_side = ReplaceMisplacedLight();
    FillUnknown();
    return result;
  }

 private:
  // pi L / E at each pixel, E = sky_scale * sky_response + sun * SunResponse.
  void AlbedoOfPixels(const glm::vec3& sky_scale) {
    tbb::parallel_for(0, view_.Height(), [&](int y) {
      for (int x = 0; x < view_.Width(); ++x) {
        const std::size_t i = view_.region.Index(x, y);
        view_.albedo_rgb.pixels[i] = glm::vec3(0.0f);
        view_.albedo_measured.pixels[i] = 0;
        if (view_.region.pixels[i] == SurfaceView::kNoRegion) continue;
        const glm::vec3 irradiance = sky_scale * view_.sky_response[0].pixels[i] +
                                     sun_ * SunResponse(view_, i, view_.sun_direction_enu);
        // A channel without any light in the map is known nowhere.
        if (!glm::all(glm::greaterThan(irradiance, least_known_))) continue;
        bool known = true;
        for (int channel = 0; channel < 3; ++channel) {
          const float albedo =
              std::numbers::pi_v<float> * input_.radiance.pixels[i][channel] / irradiance[channel];
          if (!(albedo <= kLargestAlbedo)) known = false;
          view_.albedo_rgb.pixels[i][channel] = std::min(albedo, kLargestAlbedo);
        }
        view_.albedo_measured.pixels[i] = known ? 1 : 0;
      }
    });
  }

  // Returns the largest move of a channel of a face's albedo.
  double UpdateFaces() {
    const std::size_t faces = scene_.FaceCount();
    means_.assign(faces, {});
    tbb::parallel_for(std::size_t{0}, faces, [&](std::size_t face) {
      if (scene_.IsExtension(face / 2)) return;
      if (!pixels_.Of(face).empty())
        means_[face] = MeanAlbedo(pixels_.Of(face), input_.side, view_);
    });
    struct MaterialMean {
      glm::dvec3 sum{0.0};
      double area_m2 = 0.0;
    };
    std::vector<MaterialMean> materials(scene_.mesh.materials.size());
    for (std::size_t face = 0; face < faces; ++face) {
      if (!means_[face].known) continue;
      MaterialMean& material = materials[scene_.MaterialOf(face / 2)];
      const double area_m2 = scene_.PatchAreaM2(face / 2);
      material.sum += area_m2 * glm::dvec3(means_[face].albedo);
      material.area_m2 += area_m2;
    }
    double largest = 0.0;
    for (std::size_t face = 0; face < faces; ++face) {
      const std::uint32_t index = scene_.MaterialOf(face / 2);
      const MaterialMean& material = materials[index];
      const glm::vec3 albedo = means_[face].known ? means_[face].albedo
                               : material.area_m2 > 0.0
                                   ? glm::vec3(material.sum / material.area_m2)
                                   : scene_.mesh.materials[index].diffuse_albedo;
      const glm::vec3 move = glm::abs(albedo - scene_.face_albedo_rgb[face]);
      largest = std::max({largest,
                          static_cast<double>(move.x),
                          static_cast<double>(move.y),
                          static_cast<double>(move.z)});
      scene_.face_albedo_rgb[face] = albedo;
    }
    return largest;
  }

  // Albedo of surfaces from their certain pixels.
  struct SurfaceAlbedo {
    glm::vec3 albedo{0.0f};
    double log_scatter = 0.0;
  };

  // The median of each channel, and how far half the pixels are from it in brightness.
  std::optional<SurfaceAlbedo> CertainAlbedo(std::span<const std::uint32_t> pixels) const {
    constexpr std::size_t kFewest = 8;
    // Any surface scatters a little.
    constexpr double kLeastScatter = 0.05;
    std::vector<float> brightness;
    std::array<std::vector<float>, 3> channels;
    for (const std::uint32_t pixel : pixels) {
      const glm::vec3& albedo = view_.albedo_rgb.pixels[pixel];
      if (input_.side.pixels[pixel] == ShadowSide::kUnsure ||
          view_.albedo_measured.pixels[pixel] == 0 ||
          view_.edge_distance_px.pixels[pixel] < kEdgeMarginPx || !(MeanOf(albedo) > 0.0f)) {
        continue;
      }
      brightness.push_back(MeanOf(albedo));
      for (int c = 0; c < 3; ++c) channels[static_cast<std::size_t>(c)].push_back(albedo[c]);
    }
    if (brightness.size() < kFewest) return std::nullopt;
    const auto at = [](std::vector<float>& values, double share) {
      const auto nth =
          values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
      std::nth_element(values.begin(), nth, values.end());
      return *nth;
    };
    const double spread = std::log(at(brightness, 0.75) / at(brightness, 0.25));
    return SurfaceAlbedo{{at(channels[0], 0.5), at(channels[1], 0.5), at(channels[2], 0.5)},
                         kLeastScatter + 0.74 * spread};
  }

  // Faces of one group and material.
  std::size_t SurfaceOf(std::size_t face) const {
    return scene_.GroupOf(face / 2) * scene_.mesh.materials.size() + scene_.MaterialOf(face / 2);
  }

  std::vector<std::optional<SurfaceAlbedo>> CertainAlbedoOfSurfaces() const {
    std::vector<std::vector<std::uint32_t>> pixels;
    for (std::size_t face = 0; face < scene_.FaceCount(); ++face) {
      const std::size_t surface = SurfaceOf(face);
      if (surface >= pixels.size()) pixels.resize(surface + 1);
      const auto of_face = pixels_.Of(face);
      pixels[surface].insert(pixels[surface].end(), of_face.begin(), of_face.end());
    }
    std::vector<std::optional<SurfaceAlbedo>> albedos;
    albedos.reserve(pixels.size());
    for (const auto& of_surface : pixels) albedos.push_back(CertainAlbedo(of_surface));
    return albedos;
  }

  // A face may lie in light that the model misplaces for the most part: then its surface's.
  static std::optional<SurfaceAlbedo> Nearer(const std::optional<SurfaceAlbedo>& face,
                                             const std::optional<SurfaceAlbedo>& whole) {
    if (!whole || !face) return whole;
    const double scatter = std::min(face->log_scatter, whole->log_scatter);
    double apart = 0.0;
    for (int c = 0; c < 3; ++c) {
      apart = std::max(apart, std::abs(std::log(double{face->albedo[c]} / whole->albedo[c])));
    }
    return SurfaceAlbedo{apart > kScatters * whole->log_scatter ? whole->albedo : face->albedo,
                         scatter};
  }

  // How far the light that the surface's albedo asks for at a pixel is from the model's, as a share
  // of the way to the other side of a shadow's edge. None where the surface's own scatter may
  // explain it, or the sides look the same.
  std::optional<double> WayToOtherSide(std::uint32_t pixel, const SurfaceAlbedo& surface) const {
    const double least_contrast = std::log(1.2);
    constexpr double kSameLight = 0.25;  // In logarithms: stains, and what the bounces miss.
    const float cosine = std::max(
        glm::dot(view_.normal_world.pixels[pixel], glm::vec3(view_.sun_direction_enu)), 0.0f);
    const glm::vec3 shaded =
        sky_ * view_.sky_response[0].pixels[pixel] + sun_ * view_.sun_bounce.pixels[pixel];
    const glm::vec3 lit = shaded + sun_ * cosine;
    const float modelled = MeanOf(glm::mix(shaded, lit, view_.sun_visibility.pixels[pixel]));
    const glm::vec3 asked_rgb = std::numbers::pi_v<float> * input_.radiance.pixels[pixel] /
                                glm::max(surface.albedo, glm::vec3(1e-3f));
    const float asked = MeanOf(asked_rgb);
    if (!(modelled > 0.0f) || !(glm::min(asked_rgb.x, glm::min(asked_rgb.y, asked_rgb.z)) > 0.0f)) {
      return std::nullopt;
    }
    // It must be some mixture of the two, its colour too: else it is another surface.
    const float lit_share = std::clamp(
        (asked - MeanOf(shaded)) / std::max(MeanOf(lit) - MeanOf(shaded), 1e-30f), 0.0f, 1.0f);
    const glm::dvec3 from_mixture =
        glm::log(glm::dvec3(asked_rgb) / glm::dvec3(glm::mix(shaded, lit, lit_share)));
    const double level = (from_mixture.x + from_mixture.y + from_mixture.z) / 3.0;
    if (!(std::abs(level) < kSameLight + sun_relative_stddev_)) return std::nullopt;
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(from_mixture[c] - level) < kSameLight)) return std::nullopt;
    }
    const double off = std::log(asked / modelled);
    const double whole = std::log((off > 0.0 ? MeanOf(lit) : MeanOf(shaded)) / modelled);
    if (!(std::abs(off) > kScatters * surface.log_scatter) || !(std::abs(whole) > least_contrast)) {
      return std::nullopt;
    }
    return off / whole;
  }

  // See the header; returns their number.
  std::size_t ReplaceMisplacedLight() {
    constexpr double kPartOfTheWay = 0.25;
    constexpr double kAllTheWay = 0.5;  // +/- this share.
    constexpr double kReachRad = 0.06;
    const auto wholes = CertainAlbedoOfSurfaces();
    std::vector<std::optional<SurfaceAlbedo>> surfaces(scene_.FaceCount());
    std::vector<std::uint8_t> is_known(scene_.FaceCount(), 0);
    const auto surface_at = [&](std::size_t pixel) -> const std::optional<SurfaceAlbedo>& {
      const auto face = static_cast<std::size_t>(input_.face.pixels[pixel]);
      if (is_known[face] == 0) {
        surfaces[face] = Nearer(CertainAlbedo(pixels_.Of(face)), wholes[SurfaceOf(face)]);
      }
      is_known[face] = 1;
      return surfaces[face];
    };
    // All are judged before any is replaced: they are what surfaces are measured by.
    std::vector<std::uint8_t> is_misplaced(view_.region.pixels.size(), 0);
    std::vector<std::uint32_t> all;
    const auto judge = [&](std::size_t i, const auto& accepts) {
      if (view_.region.pixels[i] == SurfaceView::kNoRegion || is_misplaced[i] != 0) return;
      const std::optional<SurfaceAlbedo>& surface = surface_at(i);
      if (!surface) return;
      const auto way = WayToOtherSide(static_cast<std::uint32_t>(i), *surface);
      if (!way || !accepts(*way)) return;
      is_misplaced[i] = 1;
      all.push_back(static_cast<std::uint32_t>(i));
    };
    for (std::size_t i = 0; i < is_misplaced.size(); ++i) {
      if (input_.side.pixels[i] != ShadowSide::kUnsure) continue;
      judge(i, [](double way) { return way > kPartOfTheWay; });
    }
    const int width = view_.Width();
    const int steps = static_cast<int>(std::ceil(kReachRad / std::numbers::pi * view_.Height()));
    std::size_t begin = 0;
    for (int step = 0; step < steps && begin < all.size(); ++step) {
      const std::size_t end = all.size();
      for (; begin < end; ++begin) {
        const int x = static_cast<int>(all[begin]) % width;
        const int y = static_cast<int>(all[begin]) / width;
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
          if (y + dy < 0 || y + dy >= view_.Height()) continue;
          const std::size_t i = view_.region.Index((x + dx + width) % width, y + dy);
          if (input_.side.pixels[i] == ShadowSide::kUnsure) continue;
          judge(i, [](double way) { return std::abs(way - 1.0) < kAllTheWay; });
        }
      }
    }
    for (const std::uint32_t i : all) {
      view_.albedo_rgb.pixels[i] = surface_at(i)->albedo;
      view_.albedo_measured.pixels[i] = 0;
    }
    return all.size();
  }

  // Pixels that are too dark take their face's albedo; pixels that are too bright keep the clamped
  // value.
  void FillUnknown() {
    for (std::size_t i = 0; i < view_.region.pixels.size(); ++i) {
      if (view_.region.pixels[i] == SurfaceView::kNoRegion) continue;
      const glm::vec3 irradiance = sky_ * view_.sky_response[0].pixels[i] +
                                   sun_ * SunResponse(view_, i, view_.sun_direction_enu);
      if (glm::all(glm::greaterThan(irradiance, least_known_))) continue;
      view_.albedo_rgb.pixels[i] =
          scene_.face_albedo_rgb[static_cast<std::size_t>(input_.face.pixels[i])];
    }
  }

  const AlbedoInput& input_;
  PatchScene& scene_;
  SurfaceView& view_;
  PixelsOfFaces pixels_;
  std::shared_ptr<const SkyShape> shape_;
  glm::vec3 sun_;
  glm::vec3 sky_;
  double sun_relative_stddev_;
  glm::vec3 least_known_;
  std::vector<glm::vec3> face_sky_;
  std::vector<glm::vec3> face_sun_;
  std::vector<glm::vec3> receiver_sky_;
  std::vector<FaceMean> means_;
};

}  // namespace

AlbedoResult SolveAlbedo(const AlbedoInput& input, PatchScene& scene, SurfaceView& view) {
  return AlbedoSolver(input, scene, view).Solve();
}

}  // namespace pleinair
