// Albedo of what a view shows: the survey's where its map sees the surface, else the materials'.
#pragma once

#include <cstdint>
#include <optional>

#include "relight/prepared_scene.h"
#include "relight/survey/survey_look_up.h"
#include "relight/transport/camera_pixels.h"
#include "relight/transport/pixel_blocks.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Immutable after construction, safe from any thread.
class ViewAlbedo {
 public:
  // Keeps a reference to `scene`.
  explicit ViewAlbedo(const PreparedScene& scene);

  // Sets albedo_rgb, albedo_measured, may_be_sampled and footprint_radius_px of `view`, whose
  // geometry stands; and in `survey_edge_distance_px` the distance to the next edge of the survey,
  // in pixels of the view, infinite where the survey says nothing. Keeps the images' memory.
  // Within planar blocks the map's places are blended between the corners.
  // Shape  side: the triangle's side that each pixel shows, PatchScene::kSky where none.
  void Fill(const CameraPixels& pixels,
            const PlanarBlocks& planar,
            const Image<std::int32_t>& side,
            SurfaceView& view,
            GrayImage& survey_edge_distance_px) const;

 private:
  class Filling;

  const PreparedScene& scene_;
  std::optional<SurveyLookUp> survey_;
};

}  // namespace pleinair
