#include "composite_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "scene/state_id.h"
#include "test_scenes.h"

namespace pleinair::test {

CompositeScene::CompositeScene(const glm::dvec3& to_sun, int width_px, int height_px)
    : phantom(Join(Ground(20.0f), Box({-4.0f, -3.6f, 0.0f}, {-2.0f, -3.4f, 3.0f}))) {
  view.camera = LookAt({4.5, -5.0, 2.2}, {0.0, 0.0, 0.9}, width_px, height_px, 0.8 * width_px);
  lighting.sun.direction_enu = to_sun;
  lighting.sun.irradiance_rgb = {800.0, 760.0, 700.0};
  lighting.sky = {{"uniform", {100.0, 130.0, 170.0}}};
  view.sun_direction_enu = to_sun;
  MakeView();
}

void CompositeScene::SetIntrinsics(const CameraIntrinsics& intrinsics) {
  view.camera.intrinsics = intrinsics;
  MakeView();
}

void CompositeScene::MakeView() {
  const CameraIntrinsics& k = view.camera.intrinsics;
  const int width = k.width_px;
  const int height = k.height_px;
  view.region_names = {"all"};
  view.region = Image<std::int32_t>(width, height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(width, height);
  view.normal_world = RgbImage(width, height);
  view.albedo_rgb = RgbImage(width, height);
  view.albedo_measured = Gray8Image(width, height, 1);
  view.may_be_sampled = Gray8Image(width, height, 1);
  view.sky_response = {RgbImage(width, height)};
  view.sun_visibility = GrayImage(width, height);
  view.sun_bounce = RgbImage(width, height);
  view.edge_distance_px = GrayImage(width, height, 20.0f);
  view.footprint_radius_px = GrayImage(width, height, 1.0f);
  view.geometry_id = StateId::Next();
  view.sky_id = StateId::Next();
  view.sun_id = StateId::Next();
  const RayCaster caster(phantom);
  const glm::vec3 eye(view.camera.CentreWorldM());
  const glm::vec3 to_sun(lighting.sun.direction_enu);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(view.camera.camera_from_world));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto in_camera = DirectionFromPixel(k, {x, y});
      if (!in_camera) continue;
      const auto hit = caster.Intersect(eye, glm::vec3(world_from_camera * *in_camera));
      if (!hit) continue;
      const std::size_t pixel = view.region.Index(x, y);
      view.region.pixels[pixel] = 0;
      view.position_world_m.pixels[pixel] = hit->position_m;
      view.normal_world.pixels[pixel] = hit->geometric_normal;
      view.albedo_rgb.pixels[pixel] = {0.5f, 0.4f, 0.3f};
      view.sky_response[0].pixels[pixel] = {0.8f, 0.81f, 0.82f};
      view.sun_bounce.pixels[pixel] = {0.05f, 0.04f, 0.03f};
      const bool is_lit =
          glm::dot(hit->geometric_normal, to_sun) > 0.0f &&
          !caster.Occluded(OffsetFromSurface(hit->position_m, hit->geometric_normal), to_sun);
      view.sun_visibility.pixels[pixel] = is_lit ? 1.0f : 0.0f;
    }
  }
  clipped = Gray8Image(width, height, 0);
  RenderCameraFromModel();
}

void CompositeScene::RenderCameraFromModel() {
  radiance = RgbImage(view.Width(), view.Height());
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    radiance.pixels[i] =
        glm::vec3(ModelRadiance(i, static_cast<double>(view.sun_visibility.pixels[i])));
  }
}

glm::dvec3 CompositeScene::ModelRadiance(std::size_t pixel, double sun_visibility) const {
  const double n_dot_l = std::max(
      0.0, glm::dot(glm::dvec3(view.normal_world.pixels[pixel]), lighting.sun.direction_enu));
  const glm::dvec3 sun = sun_visibility * n_dot_l + glm::dvec3(view.sun_bounce.pixels[pixel]);
  return glm::dvec3(view.albedo_rgb.pixels[pixel]) / std::numbers::pi *
         (lighting.SkyIrradianceRgb() * glm::dvec3(view.sky_response[0].pixels[pixel]) +
          lighting.sun.irradiance_rgb * sun);
}

CompositeInput CompositeScene::Input(
    std::span<const std::vector<glm::vec3>> vertex_irradiance) const {
  return {radiance, clipped, view, lighting, vertex_irradiance, {}};
}

glm::dvec3 ShadedObject(const Mesh& mesh,
                        const VisiblePoint& point,
                        const pleinair::Camera& camera,
                        const LightOnObject& light) {
  const DirectionalLight& sun = light.lighting.sun;
  const glm::uvec3& triangle = mesh.triangles[point.hit.triangle];
  const Material& material = mesh.materials[mesh.triangle_material[point.hit.triangle]];
  const glm::dvec2 weights(point.hit.barycentric);
  const glm::dvec3 n =
      glm::normalize((1.0 - weights.x - weights.y) * glm::dvec3(mesh.normals[triangle.x]) +
                     weights.x * glm::dvec3(mesh.normals[triangle.y]) +
                     weights.y * glm::dvec3(mesh.normals[triangle.z]));
  const glm::dvec3 l = sun.direction_enu;
  const glm::dvec3 v = glm::normalize(camera.CentreWorldM() - glm::dvec3(point.hit.position_m));
  const glm::dvec3 d(material.diffuse_albedo);
  const glm::dvec3 k(material.specular_reflectance);
  glm::dvec3 radiance = glm::min(d + k, glm::dvec3(1.0)) * light.irradiance / std::numbers::pi;
  const double n_dot_l = glm::dot(n, l);
  if (light.sun <= 0.0 || n_dot_l <= 0.0) return radiance;
  glm::dvec3 reflectance = d / std::numbers::pi;
  if (std::max({k.r, k.g, k.b}) > 0.0) {
    const double radius = sun.angular_radius_rad;
    const double alpha = std::pow(static_cast<double>(material.roughness), 2.0);
    const double alpha2 = alpha * alpha + 0.25 * radius * radius;
    const glm::dvec3 h = glm::normalize(v + l);
    const double n_dot_h = glm::dot(n, h);
    const double n_dot_v = std::max(glm::dot(n, v), 1e-4);
    const double spread = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
    const double density = alpha2 / (std::numbers::pi * spread * spread);
    const auto lambda = [&](double cosine) {
      return 0.5 * (std::sqrt(1.0 + alpha2 * (1.0 / (cosine * cosine) - 1.0)) - 1.0);
    };
    const double masking = 1.0 / (1.0 + lambda(n_dot_l) + lambda(n_dot_v));
    const glm::dvec3 at_grazing = glm::clamp(50.0 * k, k, glm::dvec3(1.0));
    const glm::dvec3 fresnel = k + (at_grazing - k) * std::pow(1.0 - glm::dot(v, h), 5.0);
    reflectance += density * masking * fresnel / (4.0 * n_dot_l * n_dot_v);
  }
  return radiance + sun.irradiance_rgb * n_dot_l * reflectance;
}

}  // namespace pleinair::test
