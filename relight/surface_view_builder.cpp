#include "relight/surface_view_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "relight/internal/looked_at_blocks.h"
#include "relight/transport/camera_pixels.h"
#include "relight/transport/edge_distance.h"
#include "relight/transport/sun_disc.h"
#include "relight/transport/surface_gather.h"
#include "relight/transport/surface_light.h"
#include "relight/transport/view_geometry.h"
#include "relight/view_albedo.h"
#include "scene/cached.h"

namespace pleinair {
namespace {

// Calls inside(x, y) for the pixels inside `polygon` that show its group.
template <typename Inside>
void ForPixelsInside(const SampleRegionPolygon& polygon,
                     const SurfaceView& view,
                     const Inside& inside) {
  std::vector<cv::Point> corners;
  for (const glm::dvec2& corner : polygon.polygon_px) {
    corners.emplace_back(static_cast<int>(std::lround(corner.x)),
                         static_cast<int>(std::lround(corner.y)));
  }
  cv::Mat drawn(view.Height(), view.Width(), CV_8U, cv::Scalar(0));
  cv::fillPoly(drawn, std::vector<std::vector<cv::Point>>{corners}, cv::Scalar(1));
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (drawn.at<std::uint8_t>(y, x) == 0) continue;
      const std::int32_t region = view.region.At(x, y);
      if (region == SurfaceView::kNoRegion) continue;
      if (polygon.group.empty() ||
          view.region_names[static_cast<std::size_t>(region)] == polygon.group) {
        inside(x, y);
      }
    }
  }
}

}  // namespace

struct SurfaceViewBuilder::Impl {
  // The view's images under a sun.
  struct SunInView {
    GrayImage visibility;
    RgbImage bounce;
    GrayImage edge_distance_px;
  };
  // Being made on another thread, or made; waits for it when it is destroyed.
  struct SunAhead {
    struct Made {
      std::shared_ptr<const FaceLight> faces;
      std::optional<SunInView> in_view;  // Where the view need not wait for the faces.
    };
    SunPlace sun;
    std::future<Made> made;
  };

  const PreparedScene& scene;
  SurfaceViewOptions options;
  ViewAlbedo albedo;
  Cached<std::shared_ptr<const Image<glm::vec3>>, CameraIntrinsics> directions_in_camera;

  SurfaceView view;
  bool is_finished = false;      // False during an Update, and after one that threw.
  Image<std::int32_t> side;      // The triangle's side that each pixel shows.
  PlanarBlocks geometry_blocks;  // Those that were not cast pixel by pixel.
  PlanarBlocks sun_blocks;
  std::vector<SampleRegionPolygon> polygons;
  std::optional<SunPlace> sun;  // The sun of the view and of sun_faces.
  // One of the two: of this view's pixels, or of the surfaces.
  SurfaceGather gather;
  std::optional<SurfaceLight> surfaces;
  Gray8Image mesh_edges;
  GrayImage survey_edge_distance_px;  // In view pixels; infinite where the survey says nothing.

  std::vector<std::shared_ptr<const SkyShape>> bare_shapes;
  std::vector<std::shared_ptr<const SkyShape>> shapes;  // bare_shapes past the skyline.
  std::vector<FaceLight> sky_faces;                     // Per shape.
  std::shared_ptr<const FaceLight> sun_faces = std::make_shared<const FaceLight>();
  StateId sun_faces_id;

  std::optional<Survey> survey_now;
  std::vector<std::shared_ptr<const SkyShape>> survey_shapes;
  StateId survey_sun_id;

  // Reads the members above: constructed last, destroyed first.
  std::optional<SunAhead> ahead;

  Impl(const PreparedScene& prepared, const SurfaceViewOptions& view_options)
      : scene(prepared), options(view_options), albedo(prepared) {}

  // Lights of `surfaces`: the sun's bounces, and each sky shape.
  static constexpr std::size_t kSunLight = 0;
  static constexpr std::size_t LightOfSky(std::size_t k) { return 1 + k; }

  bool IsOnSurfaces() const {
    return options.receivers_at == SurfaceViewOptions::ReceiversAt::kSurfaces;
  }

  int BlockPx(int stated) const {
    constexpr int kOfMovingCameras = 4;
    return stated > 0 ? stated : IsOnSurfaces() ? kOfMovingCameras : 1;
  }

  // Whether a view can be made in part.
  bool TakesParts(std::span<const SampleRegionPolygon> limits) const {
    const int block_px = BlockPx(options.geometry_block_px);
    return IsOnSurfaces() && limits.empty() && block_px > 1 &&
           block_px == BlockPx(options.sun_block_px);
  }

  void BuildGeometry(const Camera& camera, const ViewPart* part) {
    // For the first view, beside it: for the most part on one thread.
    if (IsOnSurfaces() && !surfaces) {
      tbb::parallel_invoke(
          [&] { CastView(camera, part); },
          [&] {
            surfaces.emplace(
                scene.patches, scene.transport.FaceRays(), options.surfaces, scene.options.gather);
          });
    } else {
      CastView(camera, part);
    }
    if (IsOnSurfaces()) surfaces->Show(side);
    view.geometry_id = StateId::Next();
  }

  void CastView(const Camera& camera, const ViewPart* part) {
    view.camera = camera;
    const CameraPixels pixels(camera);
    const ViewRays rays = pixels.Rays(directions_in_camera.Get(
        camera.intrinsics, [&] { return DirectionsInCamera(camera.intrinsics); }));
    ChooseBlocks choose;
    if (part != nullptr) {
      choose = [&](const PixelBlocks& blocks) { return LookedAtBlocks(*part, blocks, view, side); };
    }
    geometry_blocks = CastGeometry(scene.patches,
                                   rays,
                                   BlockPx(options.geometry_block_px),
                                   view,
                                   side,
                                   choose,
                                   geometry_blocks);
    view.is_whole = geometry_blocks.blocks.IsWhole();
    const int sun_block_px = BlockPx(options.sun_block_px);
    sun_blocks = sun_block_px == geometry_blocks.blocks.SidePx()
                     ? geometry_blocks
                     : FindPlanarBlocks(view, rays.origin_m, sun_block_px);
    MeshEdgesInBlocks(view, rays.origin_m, geometry_blocks, mesh_edges);
    albedo.Fill(pixels, geometry_blocks, side, view, survey_edge_distance_px);
    if (!IsOnSurfaces()) {
      gather =
          SurfaceGather(scene.patches, rays, view, options.receiver_block_px, scene.options.gather);
    }
  }

  // Returns which are new; they have no light on faces yet.
  std::vector<std::size_t> SetShapes(std::span<const std::shared_ptr<const SkyShape>> wanted) {
    const std::vector<std::shared_ptr<const SkyShape>> before = std::exchange(
        bare_shapes, std::vector<std::shared_ptr<const SkyShape>>(wanted.begin(), wanted.end()));
    shapes.resize(bare_shapes.size());
    sky_faces.resize(shapes.size());
    view.sky_shape_names.resize(shapes.size());
    view.sky_response.resize(shapes.size());
    std::vector<std::size_t> are_new;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      if (k < before.size() && before[k] == bare_shapes[k]) continue;
      shapes[k] = scene.survey ? SeenPast(scene.survey->skyline, bare_shapes[k]) : bare_shapes[k];
      view.sky_shape_names[k] = shapes[k]->Name();
      are_new.push_back(k);
    }
    return are_new;
  }

  void FillSky(std::span<const std::size_t> of_shapes) {
    if (!surfaces) SkyResponses(gather, of_shapes, view);
    view.sky_id = StateId::Next();
  }

  // Fills the sky responses of the view over whose pixels `receivers` are blended.
  void SkyResponses(const SurfaceGather& receivers,
                    std::span<const std::size_t> of_shapes,
                    SurfaceView& of_view) const {
    std::vector<const SkyShape*> skies;
    for (const std::size_t k : of_shapes) skies.push_back(shapes[k].get());
    std::vector<std::vector<glm::vec3>> responses = receivers.Rays().FromSkies(skies);
    for (std::size_t i = 0; i < of_shapes.size(); ++i) {
      const std::size_t k = of_shapes[i];
      std::vector<glm::vec3>& response = responses[i];
      const std::vector<glm::vec3> bounced = receivers.Rays().FromFaces(sky_faces[k].radiosity);
      for (std::size_t r = 0; r < response.size(); ++r) response[r] += bounced[r];
      RgbImage& image = of_view.sky_response[k];
      image.width = of_view.Width();
      image.height = of_view.Height();
      receivers.Blend(response, image.pixels);
    }
  }

  void UpdateSurveySky(Survey& survey) {
    const std::vector<std::shared_ptr<const SkyShape>> before =
        std::exchange(survey_shapes, shapes);
    survey.view.sky_shape_names = view.sky_shape_names;
    survey.view.sky_response.resize(shapes.size());
    std::vector<std::size_t> are_new;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      if (k >= before.size() || before[k] != shapes[k]) are_new.push_back(k);
    }
    SkyResponses(*survey.gather, are_new, survey.view);
    if (!are_new.empty()) survey.view.sky_id = StateId::Next();
  }

  void LimitTo(std::span<const SampleRegionPolygon> limits) {
    polygons.assign(limits.begin(), limits.end());
    view.judged_sun = {};
    if (polygons.empty()) return;
    const Gray8Image allowed = std::exchange(
        view.may_be_sampled, Gray8Image(view.Width(), view.Height(), std::uint8_t{0}));
    view.judged_sun = Image<JudgedSun>(view.Width(), view.Height(), JudgedSun::kUnknown);
    for (const SampleRegionPolygon& polygon : polygons) {
      ForPixelsInside(polygon, view, [&](int x, int y) {
        view.may_be_sampled.At(x, y) = allowed.At(x, y);
        view.judged_sun.At(x, y) = polygon.sun;
      });
    }
  }

  std::shared_ptr<const FaceLight> SolveSun(const SunPlace& of) const {
    return std::make_shared<const FaceLight>(scene.transport.SolveSun(
        scene.patches, of.bounces_from_enu, of.angular_radius_rad, scene.options.bounces));
  }

  // Light on faces of new shapes, and of a sun where one is given, whose is returned.
  std::shared_ptr<const FaceLight> SolveNew(std::span<const std::size_t> new_shapes,
                                            const SunPlace* new_sun) {
    std::vector<std::shared_ptr<const SkyShape>> skies;
    for (const std::size_t k : new_shapes) skies.push_back(shapes[k]);
    std::optional<PatchTransport::Sun> of_sun;
    if (new_sun != nullptr) of_sun = {new_sun->bounces_from_enu, new_sun->angular_radius_rad};
    std::vector<FaceLight> lights =
        scene.transport.SolveTogether(scene.patches, skies, of_sun, scene.options.bounces);
    std::vector<SurfaceLight::IndexedLight> on_surfaces;
    for (std::size_t i = 0; i < new_shapes.size(); ++i) {
      const std::size_t k = new_shapes[i];
      sky_faces[k] = std::move(lights[i]);
      on_surfaces.push_back({LightOfSky(k), shapes[k], sky_faces[k].radiosity});
    }
    if (surfaces) surfaces->SetLights(std::move(on_surfaces));
    return new_sun != nullptr ? std::make_shared<const FaceLight>(std::move(lights.back()))
                              : nullptr;
  }

  // The present ones where the sun's bounces come from the same place, else null.
  std::shared_ptr<const FaceLight> PresentSunFaces(const SunPlace& wanted) const {
    const bool are_its_own = sun && sun->bounces_from_enu == wanted.bounces_from_enu &&
                             sun->angular_radius_rad == wanted.angular_radius_rad;
    return are_its_own ? sun_faces : nullptr;
  }

  // Reads the geometry, which has to stand meanwhile. On surfaces without bounces. Keeps the
  // images' memory.
  void MakeSunInView(const SunPlace& of, const FaceLight& faces, SunInView& in_view) const {
    const SunDisc disc(of.direction_enu, of.angular_radius_rad, options.sun_disc_samples);
    SunVisibilityInBlocks(scene.patches.caster, disc, sun_blocks, view, in_view.visibility);
    if (!surfaces) {
      SizeFor(geometry_blocks.blocks, in_view.bounce);
      gather.Blend(gather.Rays().FromFaces(faces.radiosity), in_view.bounce.pixels);
    }
    Gray8Image edges = mesh_edges;
    AddShadowEdges(view, in_view.visibility, false, edges);
    DistanceToEdgeOrBorder(edges, in_view.edge_distance_px);
    tbb::parallel_for(0, view.Height(), [&](int y) {
      const std::size_t begin = edges.Index(0, y);
      for (std::size_t i = begin; i < begin + static_cast<std::size_t>(edges.width); ++i) {
        float& distance_px = in_view.edge_distance_px.pixels[i];
        distance_px = std::min(distance_px, survey_edge_distance_px.pixels[i]);
      }
    });
  }

  // The light that was computed ahead, where it is of this sun.
  std::optional<SunAhead::Made> TakeAhead(const SunPlace& wanted) {
    if (!ahead || ahead->sun != wanted) return std::nullopt;
    std::future<SunAhead::Made> made = std::move(ahead->made);
    ahead.reset();
    return made.get();
  }

  // Makes the light of new shapes, and of another sun, on faces; returns what of that sun's view
  // came with it.
  std::optional<SunInView> SetLights(std::span<const std::size_t> new_shapes,
                                     const SunPlace& wanted) {
    std::optional<SunAhead::Made> made;
    if (sun != wanted) made = TakeAhead(wanted);
    if (!made) made = {PresentSunFaces(wanted), std::nullopt};
    const bool has_faces = made->faces != nullptr;
    std::shared_ptr<const FaceLight> solved = SolveNew(new_shapes, has_faces ? nullptr : &wanted);
    if (!has_faces) made->faces = std::move(solved);
    sun = wanted;
    if (made->faces != sun_faces) {
      sun_faces = std::move(made->faces);
      sun_faces_id = StateId::Next();
      if (surfaces) surfaces->SetLight(kSunLight, nullptr, sun_faces->radiosity);
    }
    return std::move(made->in_view);
  }

  void FillSun(SunInView in_view) {
    view.sun_direction_enu = sun->direction_enu;
    view.sun_visibility = std::move(in_view.visibility);
    view.sun_bounce = std::move(in_view.bounce);
    view.edge_distance_px = std::move(in_view.edge_distance_px);
    view.sun_id = StateId::Next();
  }

  // The view's images, to be recomputed: their memory stays, and what is blank in them.
  SunInView TakeSun() {
    return {std::move(view.sun_visibility),
            std::move(view.sun_bounce),
            std::move(view.edge_distance_px)};
  }

  // On surfaces: fills the view's bounces of the sun, and its response to these shapes.
  void LookUp(bool with_sun, std::span<const std::size_t> of_shapes) {
    std::vector<std::size_t> lights;
    std::vector<RgbImage*> images;
    if (with_sun) {
      lights.push_back(kSunLight);
      images.push_back(&view.sun_bounce);
    }
    for (const std::size_t k : of_shapes) {
      lights.push_back(LightOfSky(k));
      images.push_back(&view.sky_response[k]);
    }
    surfaces->LookUp(geometry_blocks, side, view.position_world_m, lights, images);
  }

  bool Stands(const Camera& camera, std::span<const SampleRegionPolygon> limits) const {
    return is_finished && view.camera == camera && std::ranges::equal(polygons, limits);
  }

  bool IsAhead(const SunPlace& wanted) const {
    return ahead && ahead->sun == wanted &&
           ahead->made.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
};

SurfaceViewBuilder::SurfaceViewBuilder(const PreparedScene& scene,
                                       const SurfaceViewOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {
  for (const auto& [name, value] : {std::pair{"geometry_block_px", options.geometry_block_px},
                                    std::pair{"sun_block_px", options.sun_block_px}}) {
    if (value >= 0) continue;
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) +
                                ": expected 0 or more");
  }
  options.surfaces.Validate();
}

SurfaceViewBuilder::~SurfaceViewBuilder() = default;

const SurfaceView& SurfaceViewBuilder::Update(
    const Camera& camera,
    const SunPlace& sun,
    std::span<const std::shared_ptr<const SkyShape>> sky_shapes,
    std::span<const SampleRegionPolygon> polygons,
    const ViewPart* part) {
  Impl& impl = *impl_;
  const bool geometry_stands =
      impl.Stands(camera, polygons) && (impl.view.is_whole || (part != nullptr && impl.sun == sun));
  // Unless it was finished, nobody knows what is blank in which image.
  if (!std::exchange(impl.is_finished, false)) impl.geometry_blocks = {};
  if (!geometry_stands) {
    // What it makes of the view reads the old one; what it makes on surfaces does not.
    if (!impl.IsOnSurfaces()) impl.ahead.reset();
    impl.BuildGeometry(camera, impl.TakesParts(polygons) ? part : nullptr);
    impl.LimitTo(polygons);
  }
  std::vector<std::size_t> shapes_to_fill = impl.SetShapes(sky_shapes);
  const bool sun_is_new = impl.sun != sun;
  std::optional<Impl::SunInView> sun_in_view = impl.SetLights(shapes_to_fill, sun);

  if (!geometry_stands) {
    shapes_to_fill.resize(impl.shapes.size());
    std::iota(shapes_to_fill.begin(), shapes_to_fill.end(), std::size_t{0});
  }
  const bool fills_sun = !geometry_stands || sun_is_new;
  if (!shapes_to_fill.empty()) impl.FillSky(shapes_to_fill);
  if (fills_sun) {
    if (sun_in_view) {
      impl.FillSun(std::move(*sun_in_view));
    } else {
      Impl::SunInView made = impl.TakeSun();
      impl.MakeSunInView(sun, *impl.sun_faces, made);
      impl.FillSun(std::move(made));
    }
  }
  if (impl.IsOnSurfaces() && (fills_sun || !shapes_to_fill.empty())) {
    impl.LookUp(fills_sun, shapes_to_fill);
  }
  impl.is_finished = true;
  return impl.view;
}

const SurfaceView& SurfaceViewBuilder::View() const { return impl_->view; }

const SurfaceView& SurfaceViewBuilder::WholeView() {
  if (!impl_->sun || (impl_->is_finished && impl_->view.is_whole)) return impl_->view;
  // Copies: what is updated is read.
  const Camera camera = impl_->view.camera;
  const SunPlace sun = *impl_->sun;
  const std::vector<std::shared_ptr<const SkyShape>> shapes = impl_->bare_shapes;
  const std::vector<SampleRegionPolygon> limits = impl_->polygons;
  return Update(camera, sun, shapes, limits);
}

bool SurfaceViewBuilder::IsAtHand(const Camera& camera,
                                  const SunPlace& sun,
                                  std::span<const SampleRegionPolygon> polygons) const {
  return impl_->Stands(camera, polygons) && (impl_->sun == sun || impl_->IsAhead(sun));
}

bool SurfaceViewBuilder::Stands(const Camera& camera,
                                std::span<const SampleRegionPolygon> polygons) const {
  return impl_->Stands(camera, polygons);
}

void SurfaceViewBuilder::MakeAhead(const SunPlace& sun) {
  Impl& impl = *impl_;
  if (!impl.sun || impl.sun == sun) return;
  if (impl.ahead) {
    const bool is_made =
        impl.ahead->made.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (!is_made || impl.ahead->sun == sun) return;
  }
  impl.ahead.reset();
  // The thread must not look at what an Update may change meanwhile: the present sun and its faces.
  impl.ahead = Impl::SunAhead{
      sun,
      std::async(std::launch::async, [&impl, sun, faces = impl.PresentSunFaces(sun)]() mutable {
        if (!faces) faces = impl.SolveSun(sun);
        Impl::SunAhead::Made made{std::move(faces), std::nullopt};
        // On surfaces a view under another sun takes no longer than a new view.
        if (!impl.IsOnSurfaces()) {
          impl.MakeSunInView(sun, *made.faces, made.in_view.emplace());
        }
        return made;
      })};
}

const Survey* SurfaceViewBuilder::SurveyUnderCurrentSun() {
  Impl& impl = *impl_;
  if (!impl.scene.survey) return nullptr;
  if (!impl.sun) throw std::logic_error("SurveyUnderCurrentSun: called before the first Update");
  if (!impl.survey_now) impl.survey_now = *impl.scene.survey;
  Survey& survey = *impl.survey_now;
  impl.UpdateSurveySky(survey);
  if (impl.survey_sun_id == impl.view.sun_id) return &survey;
  const SunDisc disc(
      impl.sun->direction_enu, impl.sun->angular_radius_rad, impl.options.sun_disc_samples);
  survey.view.sun_direction_enu = impl.sun->direction_enu;
  survey.view.sun_visibility = SunVisibility(impl.scene.patches.caster, disc, survey.view);
  survey.gather->Blend(survey.gather->Rays().FromFaces(impl.sun_faces->radiosity),
                       survey.view.sun_bounce.pixels);
  survey.view.sun_id = StateId::Next();
  impl.survey_sun_id = impl.view.sun_id;
  return &survey;
}

const FaceLight& SurfaceViewBuilder::SunFaces() const { return *impl_->sun_faces; }

StateId SurfaceViewBuilder::SunFacesId() const { return impl_->sun_faces_id; }

std::span<const std::shared_ptr<const SkyShape>> SurfaceViewBuilder::SkyShapes() const {
  return impl_->shapes;
}

const Image<std::int32_t>& SurfaceViewBuilder::PixelSides() const { return impl_->side; }

const FaceLight& SurfaceViewBuilder::SkyFaces(std::size_t k) const {
  return impl_->sky_faces.at(k);
}

}  // namespace pleinair
