#include "relight/survey.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "relight/internal/edge_distance.h"
#include "relight/internal/map_rays.h"
#include "relight/internal/sun_disc.h"
#include "relight/internal/surface_gather.h"
#include "relight/internal/survey_albedo.h"
#include "relight/internal/survey_light.h"
#include "scene/lat_long.h"

namespace pleinair {
namespace {

[[noreturn]] void Refuse(const std::string& what, const char* expected) {
  throw std::invalid_argument("environment map: " + what + ": expected " + expected);
}

// Share of the disc that the scene leaves free at a point in the air.
double SunSeenFrom(const SurveyMap& map, const PatchScene& scene, int samples) {
  const glm::vec3 towards(glm::normalize(map.sun_direction_enu));
  return SunVisibility(scene.caster,
                       {glm::vec3(map.position_m), towards},
                       map.sun_direction_enu,
                       map.sun_angular_radius_rad,
                       samples);
}

void MarkSampleable(const PatchScene& scene,
                    const Image<std::int32_t>& face,
                    std::span<const std::uint8_t> patch_is_diffuse,
                    const Gray8Image* mask,
                    SurfaceView& view) {
  view.may_be_sampled = Gray8Image(view.Width(), view.Height(), 0);
  for (std::size_t i = 0; i < face.pixels.size(); ++i) {
    if (face.pixels[i] == PatchScene::kSky) continue;
    const auto patch = static_cast<std::size_t>(face.pixels[i]) / 2;
    const bool allowed = patch_is_diffuse[patch] != 0 &&
                         scene.source_triangle[patch] != PatchScene::kExtension &&
                         (mask == nullptr || mask->pixels[i] == 255);
    view.may_be_sampled.pixels[i] = allowed && view.albedo_measured.pixels[i] != 0;
  }
}

}  // namespace

void SurveyMap::Validate() const {
  const std::string size = std::to_string(radiance.width) + "x" + std::to_string(radiance.height);
  if (radiance.width != 2 * radiance.height || radiance.height < 8) {
    Refuse("it has " + size + " pixels", "twice as wide as high, at least 16x8");
  }
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const float value = radiance.pixels[i][channel];
      if (!(value >= 0.0f) || !std::isfinite(value)) {
        const int width = radiance.width;
        Refuse("pixel (" + std::to_string(static_cast<int>(i) % width) + ", " +
                   std::to_string(static_cast<int>(i) / width) + ") is " + std::to_string(value),
               "a finite radiance >= 0");
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(position_m[axis])) Refuse("position_m is not finite", "metres");
    if (!std::isfinite(clear_sky_beam_to_diffuse_rgb[axis]) ||
        clear_sky_beam_to_diffuse_rgb[axis] < 0.0) {
      Refuse(
          "clear_sky_beam_to_diffuse_rgb is " + std::to_string(clear_sky_beam_to_diffuse_rgb[axis]),
          "a finite ratio >= 0");
    }
  }
  const double length = glm::length(sun_direction_enu);
  if (!(std::abs(length - 1.0) < 1e-3)) {
    Refuse("sun_direction_enu has length " + std::to_string(length), "a unit vector");
  }
  if (!(sun_angular_radius_rad > 0.0) || !(sun_angular_radius_rad < 0.1)) {
    Refuse("sun_angular_radius_rad is " + std::to_string(sun_angular_radius_rad),
           "more than 0 and less than 0.1");
  }
}

Survey MakeSurvey(const SurveyMap& map,
                  const PatchTransport& transport,
                  std::span<const std::uint8_t> patch_is_diffuse,
                  const Gray8Image* mask,
                  const SurveyOptions& options,
                  PatchScene& scene) {
  map.Validate();
  if (patch_is_diffuse.size() != scene.mesh.triangles.size()) {
    throw std::invalid_argument("patch_is_diffuse has " + std::to_string(patch_is_diffuse.size()) +
                                " entries: expected one for each of the " +
                                std::to_string(scene.mesh.triangles.size()) + " patches");
  }
  if (mask != nullptr &&
      (mask->width != map.radiance.width || mask->height != map.radiance.height)) {
    throw std::invalid_argument("diffuse_mask has " + std::to_string(mask->width) + "x" +
                                std::to_string(mask->height) + " pixels: expected the map's " +
                                std::to_string(map.radiance.width) + "x" +
                                std::to_string(map.radiance.height));
  }

  Survey survey;
  survey.position_m = map.position_m;
  SurfaceView& view = survey.view;
  const ViewRays rays =
      MapRays({map.radiance.width, map.radiance.height}, glm::vec3(map.position_m));
  const Image<std::int32_t> face = CastGeometry(scene, rays, view);

  Gray8Image shows_sky(rays.width, rays.height, 0);
  for (int y = 0; y < rays.height; ++y) {
    for (int x = 0; x < rays.width; ++x) {
      const bool free = face.At(x, y) == PatchScene::kSky;
      shows_sky.At(x, y) = free && rays.direction(x, y)->z > 0.0f ? 255 : 0;
    }
  }
  survey.light =
      MeasureSurveyLight(map, shows_sky, SunSeenFrom(map, scene, options.sun_disc_samples));

  const SunDisc disc(
      survey.light.sun_direction_enu, map.sun_angular_radius_rad, options.sun_disc_samples);
  CastSunVisibility(scene.caster, disc, 1, view);
  Gray8Image edges = MeshEdges(view, rays.origin_m, rays.wraps_x);
  AddShadowEdges(view, rays.wraps_x, edges);
  view.edge_distance_px = DistanceTo(edges, rays.wraps_x, false);
  view.footprint_radius_px = GrayImage(rays.width, rays.height, 0.5f);

  const auto gather =
      std::make_shared<SurfaceGather>(scene, rays, view, options.receiver_block_px, options.gather);
  survey.gather = gather;
  const AlbedoResult solved = SolveAlbedo({.radiance = map.radiance,
                                           .light = survey.light,
                                           .sun_angular_radius_rad = map.sun_angular_radius_rad,
                                           .face = face,
                                           .gather = *gather,
                                           .transport = transport,
                                           .bounces = options.bounces},
                                          scene,
                                          view);
  constexpr double kWorthANote = 1e-3;
  if (solved.last_change > kWorthANote) {
    survey.light.notes.push_back("survey albedo: still moved by " +
                                 std::to_string(solved.last_change) + " after " +
                                 std::to_string(solved.iterations) + " iterations");
  }
  MarkSampleable(scene, face, patch_is_diffuse, mask, view);
  view.geometry_version = 1;
  view.sun_version = 1;
  return survey;
}

}  // namespace pleinair
