// A yard with known albedos and light, and the HDR map that a camera would take of it.
#pragma once

#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/prepared_scene.h"
#include "relight/survey/internal/map_rays.h"
#include "relight/transport/surface_gather.h"
#include "relight/transport/view_geometry.h"
#include "scene/lat_long.h"
#include "tests/relight/probe_test_scenes.h"
#include "tests/relight/solve_sky.h"

namespace pleinair {

// Nothing is kept.
struct KnownSite {
  static constexpr LatLongSize kMapSize{256, 128};

  Mesh mesh;  // Materials: 0 ground, 1 house, 2 low wall.
  glm::dvec3 position_m{0.0, 0.0, 1.6};
  glm::dvec3 sun_direction_enu = glm::normalize(glm::dvec3(-0.5, -0.4, 0.8));
  glm::dvec3 sun_irradiance_rgb{900.0, 850.0, 780.0};
  RgbImage sky;  // Radiance.

  KnownSite() {
    const auto add = [this](const char* name, std::uint32_t material, auto&& add_to) {
      Mesh part;
      add_to(part);
      const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
      for (const glm::uvec3& triangle : part.triangles) mesh.triangles.push_back(triangle + first);
      mesh.positions_m.insert(
          mesh.positions_m.end(), part.positions_m.begin(), part.positions_m.end());
      mesh.normals.insert(mesh.normals.end(), part.normals.begin(), part.normals.end());
      mesh.triangle_material.resize(mesh.triangles.size(), material);
      mesh.triangle_group.resize(mesh.triangles.size(),
                                 static_cast<std::uint32_t>(mesh.group_names.size()));
      mesh.group_names.emplace_back(name);
    };
    add("ground", 0, [](Mesh& part) { AddGround(part, 30.0f); });
    add("house", 1, [](Mesh& part) { AddBox(part, {-8, 4, 0}, {8, 10, 5}); });
    add("low_wall", 2, [](Mesh& part) { AddBox(part, {4, -3, 0}, {4.4f, 3, 1.2f}); });
    // Albedos are left at the default, as in a site whose materials nobody has measured.
    mesh.materials = {{.name = "paving"}, {.name = "brick"}, {.name = "concrete"}};

    sky = RgbImage(kMapSize.width, kMapSize.height, glm::vec3(0.0f));
    for (int y = 0; y < kMapSize.height / 2; ++y) {
      for (int x = 0; x < kMapSize.width; ++x) {
        const glm::dvec3 d = DirectionFromLatLong({x + 0.5, y + 0.5}, kMapSize);
        const double low = 1.0 - d.z;
        sky.At(x, y) = glm::vec3(22.0 + 12.0 * low, 32.0 + 8.0 * low, 55.0 - 5.0 * d.y);
      }
    }
  }

  static glm::vec3 AlbedoOf(std::uint32_t material) {
    static const glm::vec3 kAlbedos[] = {
        {0.30f, 0.29f, 0.27f}, {0.45f, 0.2f, 0.12f}, {0.6f, 0.6f, 0.55f}};
    return kAlbedos[material];
  }

  // The map, from the transport itself with rays of its own. Without the sun: neither disc nor
  // light of it, as under a cloud.
  RgbImage Map(bool with_sun = true) const {
    PatchScene scene = BuildPatchScene(mesh, {.patch_size_m = 0.9, .growth_per_m = 0.2});
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      scene.face_albedo_rgb[face] = AlbedoOf(scene.mesh.triangle_material[face / 2]);
    }
    constexpr GatherOptions kOwnRays{.rays_per_receiver = 96, .seed = 99};
    const PatchTransport transport(scene, kOwnRays);
    const auto shape = MakeImageSkyShape("known", sky);
    const glm::vec3 sky_irradiance(HorizontalIrradiance(sky));
    const glm::vec3 sun(with_sun ? sun_irradiance_rgb : glm::dvec3(0.0));

    SurfaceView view;
    const ViewRays rays = MapRays(kMapSize, glm::vec3(position_m));
    Image<std::int32_t> face;
    CastGeometry(scene, rays, 1, view, face);
    view.sun_direction_enu = sun_direction_enu;
    view.sun_visibility =
        SunVisibility(scene.caster, SunDisc(sun_direction_enu, kMeanSunAngularRadiusRad, 64), view);
    const SurfaceGather gather(scene, rays, view, 3, kOwnRays);
    const auto response = [&](const std::vector<glm::vec3>& direct, const FaceLight& faces) {
      std::vector<glm::vec3> sum = gather.Rays().FromFaces(faces.radiosity);
      for (std::size_t i = 0; i < direct.size(); ++i) sum[i] += direct[i];
      std::vector<glm::vec3> at_pixels;
      gather.Blend(sum, at_pixels);
      return at_pixels;
    };
    const std::vector<glm::vec3> of_sky =
        response(gather.Rays().FromSky(*shape), SolveSky(transport, scene, *shape, kAllBounces));
    view.sun_bounce = RgbImage(view.Width(), view.Height());
    view.sun_bounce.pixels = response(
        {}, transport.SolveSun(scene, sun_direction_enu, kMeanSunAngularRadiusRad, kAllBounces));

    RgbImage map = sky;
    for (std::size_t i = 0; i < map.pixels.size(); ++i) {
      const std::int32_t region = view.region.pixels[i];
      if (region == SurfaceView::kNoRegion) continue;
      const bool is_ground = region == 0 || region == 3;  // The extension is group 3.
      const glm::vec3 albedo = AlbedoOf(is_ground ? 0u : static_cast<std::uint32_t>(region));
      map.pixels[i] = albedo / std::numbers::pi_v<float> *
                      (sky_irradiance * of_sky[i] + sun * SunResponse(view, i, sun_direction_enu));
    }
    const glm::ivec2 at = LatLongPixelFromDirection(sun_direction_enu, kMapSize);
    const bool is_hidden = view.region.At(at.x, at.y) != SurfaceView::kNoRegion;
    if (with_sun && !is_hidden) AddDisc(map, sun_direction_enu, glm::vec3(sun_irradiance_rgb));
    return map;
  }

  // All of the disc in the pixel that holds its centre: a disc is smaller than this map's pixels.
  static void AddDisc(RgbImage& map, const glm::dvec3& direction, const glm::vec3& irradiance) {
    const glm::ivec2 pixel = LatLongPixelFromDirection(direction, kMapSize);
    map.At(pixel.x, pixel.y) +=
        irradiance / static_cast<float>(LatLongPixelSolidAngleSr(pixel.y, kMapSize));
  }

  SiteModel Model(RgbImage map) const {
    SiteModel site;
    site.mesh = mesh;
    site.environment = SurveyMap{.radiance = std::move(map),
                                 .position_m = position_m,
                                 .sun_direction_enu = sun_direction_enu,
                                 .clear_sky_beam_to_diffuse_rgb = {8.0, 6.0, 4.0}};
    return site;
  }

  static PrepareOptions Options() {
    PrepareOptions options;
    options.gather.rays_per_receiver = 128;
    options.patches = {.patch_size_m = 0.8, .growth_per_m = 0.15};
    options.probe_box = {{-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 1.2f}};
    options.probe_counts = {2, 2, 2};
    options.probes.rays_per_probe = 128;
    return options;
  }
};

// The site, its map and its survey are made once for all tests of a program.
inline const KnownSite& TheKnownSite() {
  static const KnownSite site;
  return site;
}

inline const RgbImage& TheKnownMap() {
  static const RgbImage map = TheKnownSite().Map();
  return map;
}

inline const PreparedScene& ThePreparedSite() {
  static const PreparedScene prepared = [] {
    KeepsNothing store;
    return PrepareScene(TheKnownSite().Model(TheKnownMap()), KnownSite::Options(), store, {});
  }();
  return prepared;
}

}  // namespace pleinair
