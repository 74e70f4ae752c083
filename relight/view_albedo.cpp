#include "relight/view_albedo.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>
#include <glm/vec2.hpp>

namespace pleinair {
namespace {

constexpr float kSmallestFootprintPx = 0.5f;
// A look-up is a mean over two texels a side: enough for a pixel that covers no more.
constexpr float kTexelOfOneLookUpPx = 0.5f;

}  // namespace

ViewAlbedo::ViewAlbedo(const PreparedScene& scene) : scene_(scene) {
  if (scene.survey) survey_.emplace(*scene.survey);
}

void ViewAlbedo::Fill(const CameraPixels& pixels,
                      const Image<std::int32_t>& face,
                      SurfaceView& view,
                      GrayImage& survey_edge_distance_px) const {
  const int width = view.Width();
  const int height = view.Height();
  Reset(width, height, glm::vec3(0.0f), view.albedo_rgb);
  Reset(width, height, std::uint8_t{0}, view.albedo_measured);
  Reset(width, height, std::uint8_t{0}, view.may_be_sampled);
  Reset(width, height, kSmallestFootprintPx, view.footprint_radius_px);
  Reset(width, height, std::numeric_limits<float>::infinity(), survey_edge_distance_px);
  const double focal_px = std::sqrt(view.camera.intrinsics.fx_px * view.camera.intrinsics.fy_px);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = view.region.Index(x, y);
      if (face.pixels[i] == PatchScene::kSky) continue;
      const auto pixel_face = static_cast<std::size_t>(face.pixels[i]);
      view.albedo_rgb.pixels[i] = scene_.patches.face_albedo_rgb[pixel_face];
      if (!survey_) {
        const std::size_t patch = pixel_face / 2;
        view.albedo_measured.pixels[i] = 1;
        view.may_be_sampled.pixels[i] =
            scene_.patch_is_diffuse[patch] != 0 &&
            scene_.patches.source_triangle[patch] != PatchScene::kExtension;
        continue;
      }
      const glm::vec3& position = view.position_world_m.pixels[i];
      const glm::vec3& normal = view.normal_world.pixels[i];
      const auto surveyed = survey_->At(position, normal, view.region.pixels[i]);
      if (!surveyed) continue;
      view.albedo_rgb.pixels[i] = surveyed->albedo_rgb;
      view.albedo_measured.pixels[i] = 1;
      view.may_be_sampled.pixels[i] = surveyed->may_be_sampled ? 1 : 0;
      const float texel_px =
          survey_->TexelSidePx(position, normal, glm::vec3(pixels.OriginM()), focal_px);
      if (texel_px < kTexelOfOneLookUpPx) {
        view.albedo_rgb.pixels[i] = PixelMean(pixels, view, {x, y}, texel_px, surveyed->albedo_rgb);
      }
      view.footprint_radius_px.pixels[i] = std::max(0.5f * texel_px, kSmallestFootprintPx);
      survey_edge_distance_px.pixels[i] = texel_px * surveyed->edge_distance_px;
    }
  });
}

// Mean albedo over a pixel that covers many texels, from one point on its plane for every two
// texels along a side (at most 8); those that the map does not see are left out.
glm::vec3 ViewAlbedo::PixelMean(const CameraPixels& pixels,
                                const SurfaceView& view,
                                const glm::ivec2& pixel,
                                float texel_px,
                                const glm::vec3& at_centre) const {
  constexpr float kMostPointsASide = 8.0f;
  const std::size_t i = view.region.Index(pixel.x, pixel.y);
  const int side =
      static_cast<int>(std::ceil(std::min(kTexelOfOneLookUpPx / texel_px, kMostPointsASide)));
  glm::dvec3 sum(0.0);
  int count = 0;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const glm::dvec2 point = glm::dvec2(pixel) +
                               glm::dvec2((column + 0.5) / side, (row + 0.5) / side) -
                               glm::dvec2(0.5);
      const auto on_plane =
          pixels.OnPlane(point, view.position_world_m.pixels[i], view.normal_world.pixels[i]);
      if (!on_plane) continue;
      const auto surveyed =
          survey_->At(*on_plane, view.normal_world.pixels[i], view.region.pixels[i]);
      if (!surveyed) continue;
      sum += glm::dvec3(surveyed->albedo_rgb);
      ++count;
    }
  }
  return count > 0 ? glm::vec3(sum / static_cast<double>(count)) : at_centre;
}

}  // namespace pleinair
