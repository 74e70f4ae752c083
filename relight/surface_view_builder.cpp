#include "relight/surface_view_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "relight/survey/survey_look_up.h"
#include "relight/transport/camera_pixels.h"
#include "relight/transport/edge_distance.h"
#include "relight/transport/sun_disc.h"
#include "relight/transport/surface_gather.h"

namespace pleinair {
namespace {

constexpr float kSmallestFootprintPx = 0.5f;

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
  struct SunKey {
    glm::dvec3 direction_enu{0.0};
    double angular_radius_rad = 0.0;
    bool operator==(const SunKey&) const = default;
  };
  struct SunPart {
    SunKey key;
    GrayImage visibility;
    FaceLight faces;
    RgbImage bounce;
    GrayImage edge_distance_px;
  };
  // Being made on another thread, or made; waits for it when it is destroyed.
  struct SunPartAhead {
    SunKey key;
    std::future<SunPart> part;
  };

  const PreparedScene& scene;
  SurfaceViewOptions options;

  SurfaceView view;
  Image<std::int32_t> face;  // That each pixel shows.
  std::vector<SampleRegionPolygon> polygons;
  std::optional<SunKey> sun;
  std::optional<CornerGather> corners;
  SurfaceGather gather;
  Gray8Image mesh_edges;
  GrayImage survey_edge_distance_px;  // In view pixels; infinite where the survey says nothing.

  std::vector<std::shared_ptr<const SkyShape>> bare_shapes;
  std::vector<std::shared_ptr<const SkyShape>> shapes;  // Those, past the skyline.
  std::vector<FaceLight> sky_faces;                     // Per shape.
  FaceLight sun_faces;
  std::uint64_t sun_faces_version = 0;

  std::optional<Survey> survey_now;
  std::vector<std::shared_ptr<const SkyShape>> survey_shapes;
  std::uint64_t survey_sun_version = 0;

  // Reads what is above: the last to be made, the first to be destroyed.
  std::optional<SunPartAhead> ahead;

  Impl(const PreparedScene& prepared, const SurfaceViewOptions& view_options)
      : scene(prepared), options(view_options) {}

  void BuildGeometry(const Camera& camera) {
    view.camera = camera;
    const CameraPixels pixels(camera);
    const ViewRays rays = pixels.Rays();
    face = CastGeometry(scene.patches, rays, view);
    mesh_edges = MeshEdges(view, rays.origin_m, rays.wraps_x);
    FillAlbedo(pixels);
    if (options.receivers_at == SurfaceViewOptions::ReceiversAt::kPatchCorners) {
      if (!corners) corners.emplace(scene.patches, scene.options.gather);
      gather = SurfaceGather(*corners, scene.patches, face, view);
    } else {
      gather =
          SurfaceGather(scene.patches, rays, view, options.receiver_block_px, scene.options.gather);
    }
    ++view.geometry_version;
  }

  // Makes what is not there yet: all of it where the view has changed, else where a shape has.
  void BuildSky(std::span<const std::shared_ptr<const SkyShape>> wanted, bool view_has_changed) {
    const std::vector<std::shared_ptr<const SkyShape>> before = std::exchange(
        bare_shapes, std::vector<std::shared_ptr<const SkyShape>>(wanted.begin(), wanted.end()));
    if (!view_has_changed && before == bare_shapes) return;
    shapes.resize(bare_shapes.size());
    sky_faces.resize(shapes.size());
    view.sky_shape_names.resize(shapes.size());
    view.sky_response.resize(shapes.size());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const bool is_new = k >= before.size() || before[k] != bare_shapes[k];
      if (is_new) {
        shapes[k] = scene.survey ? SeenPast(scene.survey->skyline, bare_shapes[k]) : bare_shapes[k];
        sky_faces[k] = scene.transport.SolveSky(scene.patches, *shapes[k], scene.options.bounces);
        view.sky_shape_names[k] = shapes[k]->Name();
      }
      if (is_new || view_has_changed) {
        view.sky_response[k].width = view.Width();
        view.sky_response[k].height = view.Height();
        SkyResponse(gather, k, view.sky_response[k].pixels);
      }
    }
    ++view.sky_version;
  }

  void SkyResponse(const SurfaceGather& receivers,
                   std::size_t k,
                   std::vector<glm::vec3>& at_pixels) const {
    std::vector<glm::vec3> response = receivers.Rays().FromSky(*shapes[k]);
    const std::vector<glm::vec3> bounced = receivers.Rays().FromFaces(sky_faces[k].radiosity);
    for (std::size_t i = 0; i < response.size(); ++i) response[i] += bounced[i];
    receivers.Blend(response, at_pixels);
  }

  void UpdateSurveySky(Survey& survey) {
    const std::vector<std::shared_ptr<const SkyShape>> before =
        std::exchange(survey_shapes, shapes);
    survey.view.sky_shape_names = view.sky_shape_names;
    survey.view.sky_response.resize(shapes.size());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      if (k < before.size() && before[k] == shapes[k]) continue;
      RgbImage& response = survey.view.sky_response[k];
      response.width = survey.view.Width();
      response.height = survey.view.Height();
      SkyResponse(*survey.gather, k, response.pixels);
    }
  }

  void FillAlbedo(const CameraPixels& pixels) {
    const int width = view.Width();
    const int height = view.Height();
    view.albedo_rgb = RgbImage(width, height, glm::vec3(0.0f));
    view.albedo_measured = Gray8Image(width, height, 0);
    view.may_be_sampled = Gray8Image(width, height, 0);
    view.footprint_radius_px = GrayImage(width, height, kSmallestFootprintPx);
    survey_edge_distance_px = GrayImage(width, height, std::numeric_limits<float>::infinity());
    const double focal_px = std::sqrt(view.camera.intrinsics.fx_px * view.camera.intrinsics.fy_px);
    std::optional<SurveyLookUp> survey;
    if (scene.survey) survey.emplace(*scene.survey);
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        const std::size_t i = view.region.Index(x, y);
        if (face.pixels[i] == PatchScene::kSky) continue;
        const auto pixel_face = static_cast<std::size_t>(face.pixels[i]);
        view.albedo_rgb.pixels[i] = scene.patches.face_albedo_rgb[pixel_face];
        if (!survey) {
          const std::size_t patch = pixel_face / 2;
          view.albedo_measured.pixels[i] = 1;
          view.may_be_sampled.pixels[i] =
              scene.patch_is_diffuse[patch] != 0 &&
              scene.patches.source_triangle[patch] != PatchScene::kExtension;
          continue;
        }
        const glm::vec3& position = view.position_world_m.pixels[i];
        const glm::vec3& normal = view.normal_world.pixels[i];
        const auto surveyed = survey->At(position, normal, view.region.pixels[i]);
        if (!surveyed) continue;
        view.albedo_rgb.pixels[i] = surveyed->albedo_rgb;
        view.albedo_measured.pixels[i] = 1;
        view.may_be_sampled.pixels[i] = surveyed->may_be_sampled ? 1 : 0;
        const float texel_px =
            survey->TexelSidePx(position, normal, glm::vec3(pixels.OriginM()), focal_px);
        if (texel_px < 1.0f) {
          view.albedo_rgb.pixels[i] =
              PixelMean(*survey, pixels, {x, y}, texel_px, surveyed->albedo_rgb);
        }
        view.footprint_radius_px.pixels[i] = std::max(0.5f * texel_px, kSmallestFootprintPx);
        survey_edge_distance_px.pixels[i] = texel_px * surveyed->edge_distance_px;
      }
    });
  }

  // Mean albedo over a pixel that covers several texels, from as many points on its plane as it has
  // texels along a side (at most 8); those that the map does not see are left out.
  glm::vec3 PixelMean(const SurveyLookUp& survey,
                      const CameraPixels& pixels,
                      const glm::ivec2& pixel,
                      float texel_px,
                      const glm::vec3& at_centre) const {
    constexpr float kMostPointsASide = 8.0f;
    const std::size_t i = view.region.Index(pixel.x, pixel.y);
    const int side = static_cast<int>(std::ceil(std::min(1.0f / texel_px, kMostPointsASide)));
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
            survey.At(*on_plane, view.normal_world.pixels[i], view.region.pixels[i]);
        if (!surveyed) continue;
        sum += glm::dvec3(surveyed->albedo_rgb);
        ++count;
      }
    }
    return count > 0 ? glm::vec3(sum / static_cast<double>(count)) : at_centre;
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

  // All that depends on the sun. Reads the geometry, which has to stand meanwhile.
  SunPart MakeSunPart(const SunKey& key) const {
    SunPart part{key, {}, {}, {}, {}};
    const SunDisc disc(key.direction_enu, key.angular_radius_rad, options.sun_disc_samples);
    part.visibility = SunVisibility(scene.patches.caster, disc, options.sun_block_px, view);
    part.faces = scene.transport.SolveSun(
        scene.patches, key.direction_enu, key.angular_radius_rad, scene.options.bounces);
    part.bounce.width = view.Width();
    part.bounce.height = view.Height();
    gather.Blend(gather.Rays().FromFaces(part.faces.radiosity), part.bounce.pixels);

    Gray8Image edges = mesh_edges;
    AddShadowEdges(view, part.visibility, false, edges);
    part.edge_distance_px = DistanceTo(edges, false, true);
    for (std::size_t i = 0; i < edges.pixels.size(); ++i) {
      part.edge_distance_px.pixels[i] =
          std::min(part.edge_distance_px.pixels[i], survey_edge_distance_px.pixels[i]);
    }
    return part;
  }

  void Use(SunPart part) {
    view.sun_direction_enu = part.key.direction_enu;
    view.sun_visibility = std::move(part.visibility);
    view.sun_bounce = std::move(part.bounce);
    view.edge_distance_px = std::move(part.edge_distance_px);
    if (sun != part.key) {
      sun_faces = std::move(part.faces);
      ++sun_faces_version;
      sun = part.key;
    }
    ++view.sun_version;
  }

  bool GeometryStands(const Camera& camera, std::span<const SampleRegionPolygon> limits) const {
    return view.geometry_version > 0 && view.camera == camera &&
           std::ranges::equal(polygons, limits);
  }

  bool IsAhead(const SunKey& key) const {
    return ahead && ahead->key == key &&
           ahead->part.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
};

SurfaceViewBuilder::SurfaceViewBuilder(const PreparedScene& scene,
                                       const SurfaceViewOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {
  if (options.sun_block_px < 1) {
    throw std::invalid_argument("sun_block_px is " + std::to_string(options.sun_block_px) +
                                ": expected 1 or more");
  }
}

SurfaceViewBuilder::~SurfaceViewBuilder() = default;

const SurfaceView& SurfaceViewBuilder::Update(
    const Camera& camera,
    const glm::dvec3& sun_direction_enu,
    double sun_angular_radius_rad,
    std::span<const std::shared_ptr<const SkyShape>> sky_shapes,
    std::span<const SampleRegionPolygon> polygons) {
  Impl& impl = *impl_;
  const bool geometry_stands = impl.GeometryStands(camera, polygons);
  if (!geometry_stands) {
    impl.ahead.reset();
    impl.BuildGeometry(camera);
    impl.LimitTo(polygons);
  }
  impl.BuildSky(sky_shapes, !geometry_stands);
  const Impl::SunKey key{sun_direction_enu, sun_angular_radius_rad};
  if (geometry_stands && impl.sun == key) return impl.view;
  if (impl.ahead && impl.ahead->key == key) {
    std::future<Impl::SunPart> part = std::move(impl.ahead->part);
    impl.ahead.reset();
    impl.Use(part.get());
  } else {
    impl.Use(impl.MakeSunPart(key));
  }
  return impl.view;
}

const SurfaceView& SurfaceViewBuilder::View() const { return impl_->view; }

bool SurfaceViewBuilder::IsAtHand(const Camera& camera,
                                  const glm::dvec3& sun_direction_enu,
                                  double sun_angular_radius_rad,
                                  std::span<const SampleRegionPolygon> polygons) const {
  const Impl::SunKey key{sun_direction_enu, sun_angular_radius_rad};
  return impl_->GeometryStands(camera, polygons) && (impl_->sun == key || impl_->IsAhead(key));
}

bool SurfaceViewBuilder::Stands(const Camera& camera,
                                std::span<const SampleRegionPolygon> polygons) const {
  return impl_->GeometryStands(camera, polygons);
}

void SurfaceViewBuilder::MakeAhead(const glm::dvec3& sun_direction_enu,
                                   double sun_angular_radius_rad) {
  Impl& impl = *impl_;
  const Impl::SunKey key{sun_direction_enu, sun_angular_radius_rad};
  if (!impl.sun || impl.sun == key) return;
  if (impl.ahead) {
    const bool is_made =
        impl.ahead->part.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (!is_made || impl.ahead->key == key) return;
  }
  impl.ahead.reset();
  impl.ahead = Impl::SunPartAhead{
      key, std::async(std::launch::async, [&impl, key] { return impl.MakeSunPart(key); })};
}

const Survey* SurfaceViewBuilder::SurveyUnderCurrentSun() {
  Impl& impl = *impl_;
  if (!impl.scene.survey) return nullptr;
  if (!impl.sun) throw std::logic_error("SurveyUnderCurrentSun: called before the first Update");
  if (!impl.survey_now) impl.survey_now = *impl.scene.survey;
  Survey& survey = *impl.survey_now;
  impl.UpdateSurveySky(survey);
  if (impl.survey_sun_version == impl.view.sun_version) return &survey;
  const SunDisc disc(
      impl.sun->direction_enu, impl.sun->angular_radius_rad, impl.options.sun_disc_samples);
  survey.view.sun_direction_enu = impl.sun->direction_enu;
  survey.view.sun_visibility = SunVisibility(impl.scene.patches.caster, disc, 1, survey.view);
  survey.gather->Blend(survey.gather->Rays().FromFaces(impl.sun_faces.radiosity),
                       survey.view.sun_bounce.pixels);
  ++survey.view.sun_version;
  impl.survey_sun_version = impl.view.sun_version;
  return &survey;
}

const FaceLight& SurfaceViewBuilder::SunFaces() const { return impl_->sun_faces; }

std::uint64_t SurfaceViewBuilder::SunFacesVersion() const { return impl_->sun_faces_version; }

std::span<const std::shared_ptr<const SkyShape>> SurfaceViewBuilder::SkyShapes() const {
  return impl_->shapes;
}

const Image<std::int32_t>& SurfaceViewBuilder::PixelFaces() const { return impl_->face; }

const FaceLight& SurfaceViewBuilder::SkyFaces(std::size_t k) const {
  return impl_->sky_faces.at(k);
}

}  // namespace pleinair
