#include "relight/view_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/vec2.hpp>

namespace pleinair {
namespace {

constexpr float kSmallestFootprintPx = 0.5f;
// A look-up is a mean over two texels a side: enough for a pixel that covers no more.
constexpr float kTexelOfOneLookUpPx = 0.5f;

}  // namespace

// One view's.
class ViewAlbedo::Filling {
 public:
  struct Filled {
    SurfaceView& view;
    GrayImage& survey_edge_distance_px;
  };

  Filling(const ViewAlbedo& albedo,
          const CameraPixels& pixels,
          const PixelBlocks& blocks,
          const Image<std::int32_t>& side,
          const Filled& filled)
      : scene_(albedo.scene_),
        survey_(albedo.survey_),
        pixels_(pixels),
        eye_m_(pixels.OriginM()),
        focal_px_(
            std::sqrt(filled.view.camera.intrinsics.fx_px * filled.view.camera.intrinsics.fy_px)),
        side_(side),
        blocks_(blocks),
        view_(filled.view),
        survey_edge_distance_px_(filled.survey_edge_distance_px) {
    if (!survey_ || blocks_.SidePx() == 1) return;
    corners_in_map_.resize(CornerColumns() * (static_cast<std::size_t>(blocks_.Rows()) + 1));
    tbb::parallel_for(0, blocks_.Rows() + 1, [&](int row) {
      const int y = blocks_.CornerY(row);
      for (int column = 0; column <= blocks_.Columns(); ++column) {
        const std::size_t pixel = side_.Index(blocks_.CornerX(column), y);
        if (side_.pixels[pixel] == PatchScene::kSky) continue;
        corners_in_map_[static_cast<std::size_t>(row) * CornerColumns() +
                        static_cast<std::size_t>(column)] = PlaceInMap(pixel);
      }
    });
  }

  void DoRow(int y, std::span<const std::uint8_t> wanted) const {
    for (int x = 0; x < view_.Width(); ++x) {
      if (wanted[static_cast<std::size_t>(x)] == 0) continue;
      const std::size_t pixel = side_.Index(x, y);
      SetBySurface(pixel);
      if (!survey_ || side_.pixels[pixel] == PatchScene::kSky) continue;
      SetBySurvey({x, y}, PlaceInMap(pixel));
    }
  }

  bool DoBetween(int column, int row, const PixelBlock& block) const {
    if (!survey_) {
      block.ForPixelsBetween([&](int x, int y) { SetBySurface(side_.Index(x, y)); });
      return true;
    }
    const std::array<InMap, 4> at = CornersInMap(column, row);
    for (std::size_t k = 1; k < 4; ++k) {
      const glm::vec2 apart = glm::abs(at[k].place - at[0].place);
      if (!(std::max(apart.x, apart.y) <= survey_->LinearWithinPx())) return false;
    }
    const PixelBlock::Blend<glm::vec2> place(block,
                                             {at[0].place, at[1].place, at[2].place, at[3].place});
    const PixelBlock::Blend<float> texel_px(
        block, {at[0].texel_px, at[1].texel_px, at[2].texel_px, at[3].texel_px});
    block.ForPixelsBetween([&](int x, int y) {
      SetBySurface(side_.Index(x, y));
      SetBySurvey({x, y}, {place(x, y), texel_px(x, y)});
    });
    return true;
  }

  // As where nothing is shown.
  void Blank(std::size_t pixel) const { SetBySurface(pixel); }

 private:
  struct InMap {
    glm::vec2 place{0.0f};
    float texel_px = 0.0f;  // Side of a texel in pixels of the view.
  };

  std::array<InMap, 4> CornersInMap(int column, int row) const {
    const auto at = [&](int dx, int dy) {
      return corners_in_map_[static_cast<std::size_t>(row + dy) * CornerColumns() +
                             static_cast<std::size_t>(column + dx)];
    };
    return {at(0, 0), at(1, 0), at(0, 1), at(1, 1)};
  }

  std::size_t CornerColumns() const { return static_cast<std::size_t>(blocks_.Columns()) + 1; }

  InMap PlaceInMap(std::size_t pixel) const {
    const glm::vec3& position_m = view_.position_world_m.pixels[pixel];
    return {survey_->PlaceOf(position_m),
            survey_->TexelSidePx(position_m, view_.normal_world.pixels[pixel], eye_m_, focal_px_)};
  }

  // By material: what there is without a survey.
  void SetBySurface(std::size_t pixel) const {
    view_.albedo_rgb.pixels[pixel] = glm::vec3(0.0f);
    view_.albedo_measured.pixels[pixel] = 0;
    view_.may_be_sampled.pixels[pixel] = 0;
    view_.footprint_radius_px.pixels[pixel] = kSmallestFootprintPx;
    survey_edge_distance_px_.pixels[pixel] = std::numeric_limits<float>::infinity();
    if (side_.pixels[pixel] == PatchScene::kSky) return;
    const auto face = static_cast<std::size_t>(scene_.patches.FaceOfSide(side_.pixels[pixel]));
    view_.albedo_rgb.pixels[pixel] = scene_.patches.face_albedo_rgb[face];
    if (survey_) return;
    const std::size_t patch = face / 2;
    view_.albedo_measured.pixels[pixel] = 1;
    view_.may_be_sampled.pixels[pixel] =
        scene_.patch_is_diffuse[patch] != 0 && !scene_.patches.IsExtension(patch);
  }

  // Where the survey sees the pixel.
  void SetBySurvey(const glm::ivec2& at, const InMap& in_map) const {
    const std::size_t pixel = side_.Index(at.x, at.y);
    const glm::vec3& position_m = view_.position_world_m.pixels[pixel];
    const glm::vec3& normal = view_.normal_world.pixels[pixel];
    const std::int32_t region = view_.region.pixels[pixel];
    const auto surveyed = survey_->At(in_map.place, position_m, normal, region);
    if (!surveyed) return;
    view_.albedo_rgb.pixels[pixel] = surveyed->albedo_rgb;
    if (in_map.texel_px < kTexelOfOneLookUpPx) {
      const auto mean =
          survey_->MeanAlbedo(in_map.place, 1.0f / in_map.texel_px, position_m, normal, region);
      view_.albedo_rgb.pixels[pixel] =
          mean ? *mean : MeanOfPoints(at, in_map.texel_px, surveyed->albedo_rgb);
    }
    view_.albedo_measured.pixels[pixel] = 1;
    view_.may_be_sampled.pixels[pixel] = surveyed->may_be_sampled ? 1 : 0;
    view_.footprint_radius_px.pixels[pixel] =
        std::max(0.5f * in_map.texel_px, kSmallestFootprintPx);
    survey_edge_distance_px_.pixels[pixel] = in_map.texel_px * surveyed->edge_distance_px;
  }

  // Mean albedo over a pixel that covers many texels, from one point on its plane for every two
  // texels along a side (at most 8). Those that the map does not see are left out.
  glm::vec3 MeanOfPoints(const glm::ivec2& at, float texel_px, const glm::vec3& at_centre) const {
    constexpr float kMostPointsASide = 8.0f;
    const std::size_t pixel = side_.Index(at.x, at.y);
    const glm::vec3& normal = view_.normal_world.pixels[pixel];
    const int side =
        static_cast<int>(std::ceil(std::min(kTexelOfOneLookUpPx / texel_px, kMostPointsASide)));
    glm::dvec3 sum(0.0);
    int count = 0;
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const glm::dvec2 point = glm::dvec2(at) +
                                 glm::dvec2((column + 0.5) / side, (row + 0.5) / side) -
                                 glm::dvec2(0.5);
        const auto on_plane = pixels_.OnPlane(point, view_.position_world_m.pixels[pixel], normal);
        if (!on_plane) continue;
        const auto surveyed = survey_->At(*on_plane, normal, view_.region.pixels[pixel]);
        if (!surveyed) continue;
        sum += glm::dvec3(surveyed->albedo_rgb);
        ++count;
      }
    }
    return count > 0 ? glm::vec3(sum / static_cast<double>(count)) : at_centre;
  }

  const PreparedScene& scene_;
  const std::optional<SurveyLookUp>& survey_;
  const CameraPixels& pixels_;
  glm::vec3 eye_m_;
  double focal_px_;
  const Image<std::int32_t>& side_;
  const PixelBlocks& blocks_;
  std::vector<InMap> corners_in_map_;  // Row by row.
  SurfaceView& view_;
  GrayImage& survey_edge_distance_px_;
};

ViewAlbedo::ViewAlbedo(const PreparedScene& scene) : scene_(scene) {
  if (scene.survey) survey_.emplace(*scene.survey);
}

void ViewAlbedo::Fill(const CameraPixels& pixels,
                      const PlanarBlocks& planar,
                      const Image<std::int32_t>& side,
                      SurfaceView& view,
                      GrayImage& survey_edge_distance_px) const {
  const PixelBlocks& blocks = planar.blocks;
  SizeFor(blocks, view.albedo_rgb);
  SizeFor(blocks, view.albedo_measured);
  SizeFor(blocks, view.may_be_sampled);
  SizeFor(blocks, view.footprint_radius_px);
  SizeFor(blocks, survey_edge_distance_px);
  const Filling filling(*this, pixels, blocks, side, {view, survey_edge_distance_px});
  ForBlocks(
      blocks,
      [&](int y, std::span<const std::uint8_t> wanted) { filling.DoRow(y, wanted); },
      [&](int column, int row, const PixelBlock& block) {
        return planar.is_planar[blocks.Index(column, row)] != 0 &&
               filling.DoBetween(column, row, block);
      },
      [&](std::size_t pixel) { filling.Blank(pixel); });
}

}  // namespace pleinair
