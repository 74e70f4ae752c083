#include "relight/internal/survey_albedo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

constexpr double kFewestRays = 16.0;  // See the header.
constexpr float kLargestAlbedo = 0.98f;
constexpr double kConverged = 1e-4;
constexpr int kMaxIterations = 30;
// A face's mean leaves out pixels this near to an edge, where it has others.
constexpr float kEdgeMarginPx = 1.5f;
// And this share of its weight at either end: glass, shadow of what the mesh lacks.
constexpr double kTrimmedShare = 0.1;

float MeanOf(const glm::vec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0f; }

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

// Mean of the face's measured pixels by solid angle, trimmed in brightness.
FaceMean MeanAlbedo(std::span<const std::uint32_t> pixels, const SurfaceView& view) {
  struct Sample {
    glm::vec3 albedo;
    double weight;
  };
  std::vector<Sample> samples;
  for (const float margin : {kEdgeMarginPx, -1.0f}) {
    for (const std::uint32_t pixel : pixels) {
      if (view.albedo_measured.pixels[pixel] == 0) continue;
      if (view.edge_distance_px.pixels[pixel] < margin) continue;
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
        shape_(MakeImageSkyShape("survey", input.light.sky_radiance)),
        sun_(input.light.sun_irradiance_rgb),
        sky_(input.light.sky_irradiance_rgb),
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
      if (scene_.source_triangle[face / 2] == PatchScene::kExtension) return;
      if (!pixels_.Of(face).empty()) means_[face] = MeanAlbedo(pixels_.Of(face), view_);
    });
    struct MaterialMean {
      glm::dvec3 sum{0.0};
      double area_m2 = 0.0;
    };
    std::vector<MaterialMean> materials(scene_.mesh.materials.size());
    for (std::size_t face = 0; face < faces; ++face) {
      if (!means_[face].known) continue;
      MaterialMean& material = materials[scene_.mesh.triangle_material[face / 2]];
      const double area_m2 = scene_.PatchAreaM2(face / 2);
      material.sum += area_m2 * glm::dvec3(means_[face].albedo);
      material.area_m2 += area_m2;
    }
    double largest = 0.0;
    for (std::size_t face = 0; face < faces; ++face) {
      const std::uint32_t index = scene_.mesh.triangle_material[face / 2];
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

  // What is too dark to know takes its face's albedo; what is too bright keeps its clamped value.
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
