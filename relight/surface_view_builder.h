// Makes and keeps up to date the SurfaceView of a camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/prepared_scene.h"
#include "relight/transport/surface_light.h"
#include "relight/view_part.h"
#include "scene/image.h"
#include "scene/judged_sun.h"
#include "scene/sky_shape.h"
#include "scene/state_id.h"
#include "scene/surface_view.h"

namespace pleinair {

struct SurfaceViewOptions {
  // Where response to sky and bounces is gathered: at receivers in the picture, new with every new
  // camera, or on a lattice over the surfaces, which stays while the camera moves.
  enum class ReceiversAt { kPixels, kSurfaces };
  ReceiversAt receivers_at = ReceiversAt::kPixels;
  SurfaceLightOptions surfaces = {};
  // At pixels: one receiver in a block of this side, blended over pixels of the same plane. 1 is
  // exact: every pixel gathers.
  int receiver_block_px = 4;
  int sun_disc_samples = 16;
  // Sides of blocks of pixels; 0: 1 for receivers in the picture, 4 for those on surfaces. Those
  // whose corners show one plane are taken to show nothing else (see CastGeometry).
  int geometry_block_px = 0;
  // Those whose corners all see the sun, or all do not, are treated as uniform: smaller details
  // may be missed. 1 is exact: every pixel casts.
  int sun_block_px = 0;
};

// Where in a picture the estimate may sample, beside the survey's own regions.
struct SampleRegionPolygon {
  std::string group;  // Empty: any.
  std::vector<glm::dvec2> polygon_px;
  JudgedSun sun = JudgedSun::kUnknown;

  bool operator==(const SampleRegionPolygon&) const = default;
};

// The sun of a view.
struct SunPlace {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};
  double angular_radius_rad = 0.0;
  // Where it stands for its bounces, which change far less than its shadows when it moves on.
  glm::dvec3 bounces_from_enu{0.0, 0.0, 1.0};

  bool operator==(const SunPlace&) const = default;
};

class SurfaceViewBuilder {
 public:
  // Keeps a reference to `scene`.
  SurfaceViewBuilder(const PreparedScene& scene, const SurfaceViewOptions& options);
  ~SurfaceViewBuilder();

  // The view of `camera` under `sky_shapes` and `sun`: kept from the last call where the arguments
  // are the same (of a shape: the same object), rebuilt in parts otherwise. A pure function of its
  // arguments; callers who want to save time snap the sun to steps of time. `polygons`, when not
  // empty, limit may_be_sampled to their insides and give judged_sun; where they overlap, the last
  // one does.
  //
  // With `part`, only that part of a new view need be made (SurfaceView::is_whole); what is made is
  // as in the whole view, but for edge_distance_px, to which the part's rim is an edge. A part
  // stands as long as camera and sun do and parts are asked for: callers ask for parts that differ
  // hardly, or for the whole view. All of it is made for receivers in the picture, with polygons,
  // where blocks are of 1 px, and where those of the geometry and of the sun differ.
  const SurfaceView& Update(const Camera& camera,
                            const SunPlace& sun,
                            std::span<const std::shared_ptr<const SkyShape>> sky_shapes,
                            std::span<const SampleRegionPolygon> polygons,
                            const ViewPart* part = nullptr);
  // With its bounces from where it stands.
  const SurfaceView& Update(const Camera& camera,
                            const glm::dvec3& sun_direction_enu,
                            double sun_angular_radius_rad,
                            std::span<const std::shared_ptr<const SkyShape>> sky_shapes,
                            std::span<const SampleRegionPolygon> polygons) {
    return Update(camera,
                  {sun_direction_enu, sun_angular_radius_rad, sun_direction_enu},
                  sky_shapes,
                  polygons);
  }

  // The view of the last Update.
  const SurfaceView& View() const;
  // The same; what is lacking of it is made, and it has another identity.
  const SurfaceView& WholeView();

  // Whether an Update would be fast: IsAtHand, except for new sky shapes; Stands, except for those
  // and the sun.
  bool IsAtHand(const Camera& camera,
                const SunPlace& sun,
                std::span<const SampleRegionPolygon> polygons) const;
  bool Stands(const Camera& camera, std::span<const SampleRegionPolygon> polygons) const;

  // Starts to compute, on another thread, the last Update's view under another sun. An Update with
  // that sun and view uses it; its result is the same as without. One at a time: does nothing while
  // another one is being computed.
  void MakeAhead(const SunPlace& sun);

  // The survey with its map's sun_visibility, sun_bounce and sky_response (per sky shape) made for
  // the sun and shapes of the last Update; computed at the first call after they changed. Null
  // without a survey.
  const Survey* SurveyUnderCurrentSun();

  // Radiosity of the faces for the unit sun that the last Update stands for; and for sky shape k.
  const FaceLight& SunFaces() const;
  const FaceLight& SkyFaces(std::size_t k) const;
  // The shapes of the last Update as the site sees them, past the survey's skyline: the view and
  // SkyFaces are under these, and these objects stay while they do.
  std::span<const std::shared_ptr<const SkyShape>> SkyShapes() const;
  // A new identity whenever SunFaces() changes; the view's sun_id also changes with the camera.
  StateId SunFacesId() const;

  // The side of the scene's triangle that each pixel of the view shows, PatchScene::kSky where
  // none.
  const Image<std::int32_t>& PixelSides() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
