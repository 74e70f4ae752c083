#include "relight/surface_view_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/lens.h"
#include "relight/internal/edge_distance.h"
#include "relight/internal/same_plane.h"
#include "relight/internal/sun_disc.h"
#include "relight/internal/surface_gather.h"
#include "scene/lat_long.h"

namespace pleinair {
namespace {

constexpr float kSmallestFootprintPx = 0.5f;

ViewRays CameraRays(const Camera& camera) {
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  return {.width = camera.intrinsics.width_px,
          .height = camera.intrinsics.height_px,
          .wraps_x = false,
          .origin_m = glm::vec3(camera.CentreWorldM()),
          .direction = [intrinsics = camera.intrinsics, world_from_camera](
                           int x, int y) -> std::optional<glm::vec3> {
            const std::optional<glm::dvec3> direction =
                DirectionFromPixel(intrinsics, {static_cast<double>(x), static_cast<double>(y)});
            if (!direction) return std::nullopt;
            return glm::vec3(glm::normalize(world_from_camera * *direction));
          }};
}

// What the survey's map says of one surface point.
struct SurveyedPoint {
  glm::vec3 albedo_rgb{0.0f};
  float edge_distance_px = 0.0f;  // In map pixels.
  bool may_be_sampled = false;
};

class SurveyLookUp {
 public:
  explicit SurveyLookUp(const Survey& survey)
      : view_(survey.view),
        origin_m_(survey.position_m),
        size_{survey.view.Width(), survey.view.Height()} {}

  // None where the map sees another surface in that direction. Bilinear over the texels that show
  // the point's own plane and whose albedo was measured.
  std::optional<SurveyedPoint> At(const glm::vec3& position_m,
                                  const glm::vec3& normal,
                                  std::int32_t region) const {
    const glm::dvec3 towards = glm::dvec3(position_m) - origin_m_;
    const float range_m = static_cast<float>(glm::length(towards));
    if (!(range_m > 0.0f)) return std::nullopt;
    const glm::dvec2 uv_px = LatLongFromDirection(towards, size_);
    const int left = static_cast<int>(std::floor(uv_px.x - 0.5));
    const int top = static_cast<int>(std::floor(uv_px.y - 0.5));
    const double fx = uv_px.x - 0.5 - left;
    const double fy = uv_px.y - 0.5 - top;
    SurveyedPoint point;
    point.edge_distance_px = std::numeric_limits<float>::infinity();
    point.may_be_sampled = true;
    glm::dvec3 sum(0.0);
    double weights = 0.0;
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const double weight = (dx == 0 ? 1.0 - fx : fx) * (dy == 0 ? 1.0 - fy : fy);
        if (!(weight > 0.0)) continue;
        const int x = (left + dx + size_.width) % size_.width;
        const int y = std::clamp(top + dy, 0, size_.height - 1);
        const std::size_t texel = view_.region.Index(x, y);
        if (view_.region.pixels[texel] != region || view_.albedo_measured.pixels[texel] == 0 ||
            !SamePlane(position_m,
                       normal,
                       view_.position_world_m.pixels[texel],
                       view_.normal_world.pixels[texel],
                       range_m)) {
          point.may_be_sampled = false;
          continue;
        }
        sum += weight * glm::dvec3(view_.albedo_rgb.pixels[texel]);
        weights += weight;
        point.may_be_sampled = point.may_be_sampled && view_.may_be_sampled.pixels[texel] != 0;
        point.edge_distance_px =
            std::min(point.edge_distance_px, view_.edge_distance_px.pixels[texel]);
      }
    }
    if (!(weights > 0.0)) return std::nullopt;
    point.albedo_rgb = glm::vec3(sum / weights);
    return point;
  }

  // Side of a texel's footprint on a surface over that of a view pixel's, seen from
  // `view_origin_m` with `focal_px`: square roots of the areas, so that slant counts.
  float TexelSidePx(const glm::vec3& position_m,
                    const glm::vec3& normal,
                    const glm::vec3& view_origin_m,
                    double focal_px) const {
    const double texel_rad = std::numbers::pi / size_.height;
    const auto side = [&](const glm::dvec3& origin_m, double pixel_rad) {
      const glm::dvec3 towards = glm::dvec3(position_m) - origin_m;
      const double range_m = glm::length(towards);
      // Seen at less than 0.6 deg of slant a surface is edge-on: there the bound keeps this finite.
      const double cosine =
          std::max(std::abs(glm::dot(towards, glm::dvec3(normal))) / range_m, 1e-2);
      return range_m * pixel_rad / std::sqrt(cosine);
    };
    return static_cast<float>(side(origin_m_, texel_rad) /
                              side(glm::dvec3(view_origin_m), 1.0 / focal_px));
  }

 private:
  const SurfaceView& view_;
  glm::dvec3 origin_m_;
  LatLongSize size_;
};

// 1 inside any of the polygons whose group is the pixel's region (or that name no group).
Gray8Image InsidePolygons(const SurfaceView& view, std::span<const SampleRegionPolygon> polygons) {
  Gray8Image inside(view.Width(), view.Height(), 0);
  for (const SampleRegionPolygon& polygon : polygons) {
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
          inside.At(x, y) = 1;
        }
      }
    }
  }
  return inside;
}

bool SamePolygons(std::span<const SampleRegionPolygon> a, std::span<const SampleRegionPolygon> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
    return p.group == q.group && p.polygon_px == q.polygon_px;
  });
}

}  // namespace

struct SurfaceViewBuilder::Impl {
  struct SunKey {
    glm::dvec3 direction_enu{0.0};
    double angular_radius_rad = 0.0;
    bool operator==(const SunKey&) const = default;
  };

  const PreparedScene& scene;
  std::vector<std::shared_ptr<const SkyShape>> shapes;
  SurfaceViewOptions options;

  SurfaceView view;
  std::vector<SampleRegionPolygon> polygons;
  std::optional<SunKey> sun;
  SurfaceGather gather;
  Gray8Image mesh_edges;
  GrayImage survey_edge_distance_px;  // In view pixels; infinite where the survey says nothing.

  std::vector<FaceLight> sky_faces;
  FaceLight sun_faces;

  std::optional<Survey> survey_now;
  std::uint64_t survey_sun_version = 0;

  Impl(const PreparedScene& prepared,
       std::vector<std::shared_ptr<const SkyShape>> sky_shapes,
       const SurfaceViewOptions& view_options)
      : scene(prepared), shapes(std::move(sky_shapes)), options(view_options) {
    for (const std::shared_ptr<const SkyShape>& shape : shapes) {
      sky_faces.push_back(scene.transport.SolveSky(scene.patches, *shape, scene.options.bounces));
    }
  }

  void BuildGeometry(const Camera& camera) {
    view.camera = camera;
    const ViewRays rays = CameraRays(camera);
    const Image<std::int32_t> face = CastGeometry(scene.patches, rays, view);
    mesh_edges = MeshEdges(view, rays.origin_m, rays.wraps_x);
    FillAlbedo(face, rays.origin_m);
    gather =
        SurfaceGather(scene.patches, rays, view, options.receiver_block_px, scene.options.gather);
    view.sky_response.assign(shapes.size(), RgbImage(view.Width(), view.Height()));
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      SkyResponse(gather, k, view.sky_response[k].pixels);
    }
    ++view.geometry_version;
  }

  void SkyResponse(const SurfaceGather& receivers,
                   std::size_t k,
                   std::vector<glm::vec3>& at_pixels) const {
    std::vector<glm::vec3> response = receivers.Rays().FromSky(*shapes[k]);
    const std::vector<glm::vec3> bounced = receivers.Rays().FromFaces(sky_faces[k].radiosity);
    for (std::size_t i = 0; i < response.size(); ++i) response[i] += bounced[i];
    receivers.Blend(response, at_pixels);
  }

  void FillAlbedo(const Image<std::int32_t>& face, const glm::vec3& origin_m) {
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
        const float texel_px = survey->TexelSidePx(position, normal, origin_m, focal_px);
        view.footprint_radius_px.pixels[i] = std::max(0.5f * texel_px, kSmallestFootprintPx);
        survey_edge_distance_px.pixels[i] = texel_px * surveyed->edge_distance_px;
      }
    });
  }

  void LimitTo(std::span<const SampleRegionPolygon> limits) {
    polygons.assign(limits.begin(), limits.end());
    if (polygons.empty()) return;
    const Gray8Image inside = InsidePolygons(view, polygons);
    for (std::size_t i = 0; i < inside.pixels.size(); ++i) {
      view.may_be_sampled.pixels[i] &= inside.pixels[i];
    }
  }

  void BuildSun(const SunKey& key) {
    const SunDisc disc(key.direction_enu, key.angular_radius_rad, options.sun_disc_samples);
    view.sun_direction_enu = key.direction_enu;
    CastSunVisibility(scene.patches.caster, disc, view);
    if (sun != key) {
      sun_faces = scene.transport.SolveSun(
          scene.patches, key.direction_enu, key.angular_radius_rad, scene.options.bounces);
      sun = key;
    }
    view.sun_bounce.width = view.Width();
    view.sun_bounce.height = view.Height();
    gather.Blend(gather.Rays().FromFaces(sun_faces.radiosity), view.sun_bounce.pixels);

    Gray8Image edges = mesh_edges;
    AddShadowEdges(view, false, edges);
    view.edge_distance_px = DistanceTo(edges, false, true);
    for (std::size_t i = 0; i < edges.pixels.size(); ++i) {
      view.edge_distance_px.pixels[i] =
          std::min(view.edge_distance_px.pixels[i], survey_edge_distance_px.pixels[i]);
    }
    ++view.sun_version;
  }
};

SurfaceViewBuilder::SurfaceViewBuilder(const PreparedScene& scene,
                                       std::vector<std::shared_ptr<const SkyShape>> sky_shapes,
                                       const SurfaceViewOptions& options)
    : impl_(std::make_unique<Impl>(scene, std::move(sky_shapes), options)) {}

SurfaceViewBuilder::~SurfaceViewBuilder() = default;

const SurfaceView& SurfaceViewBuilder::Update(const Camera& camera,
                                              const glm::dvec3& sun_direction_enu,
                                              double sun_angular_radius_rad,
                                              std::span<const SampleRegionPolygon> polygons) {
  Impl& impl = *impl_;
  const bool geometry_stands = impl.view.geometry_version > 0 && impl.view.camera == camera &&
                               SamePolygons(impl.polygons, polygons);
  if (!geometry_stands) {
    impl.BuildGeometry(camera);
    impl.LimitTo(polygons);
  }
  const Impl::SunKey key{sun_direction_enu, sun_angular_radius_rad};
  if (!geometry_stands || impl.sun != key) impl.BuildSun(key);
  return impl.view;
}

const Survey* SurfaceViewBuilder::SurveyUnderCurrentSun() {
  Impl& impl = *impl_;
  if (!impl.scene.survey) return nullptr;
  if (!impl.sun) throw std::logic_error("SurveyUnderCurrentSun: called before the first Update");
  if (!impl.survey_now) {
    impl.survey_now = *impl.scene.survey;
    SurfaceView& view = impl.survey_now->view;
    view.sky_response.assign(impl.shapes.size(), RgbImage(view.Width(), view.Height()));
    for (std::size_t k = 0; k < impl.shapes.size(); ++k) {
      impl.SkyResponse(*impl.survey_now->gather, k, view.sky_response[k].pixels);
    }
  } else if (impl.survey_sun_version == impl.view.sun_version) {
    return &*impl.survey_now;
  }
  Survey& survey = *impl.survey_now;
  const SunDisc disc(
      impl.sun->direction_enu, impl.sun->angular_radius_rad, impl.options.sun_disc_samples);
  survey.view.sun_direction_enu = impl.sun->direction_enu;
  CastSunVisibility(impl.scene.patches.caster, disc, survey.view);
  survey.gather->Blend(survey.gather->Rays().FromFaces(impl.sun_faces.radiosity),
                       survey.view.sun_bounce.pixels);
  ++survey.view.sun_version;
  impl.survey_sun_version = impl.view.sun_version;
  return &survey;
}

const FaceLight& SurfaceViewBuilder::SunFaces() const { return impl_->sun_faces; }

const FaceLight& SurfaceViewBuilder::SkyFaces(std::size_t k) const {
  return impl_->sky_faces.at(k);
}

}  // namespace pleinair
