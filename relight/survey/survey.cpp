#include "relight/survey/survey.h"
#include "relight/transport/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "relight/survey/internal/map_rays.h"
#include "relight/survey/internal/shadow_pairs.h"
#include "relight/survey/internal/shadow_side.h"
#include "relight/survey/internal/survey_albedo.h"
#include "relight/survey/internal/survey_light.h"
#include "relight/survey/internal/survey_skyline.h"
#include "relight/survey/internal/unmodelled_shade.h"
#include "relight/transport/edge_distance.h"
#include "relight/transport/sun_disc.h"
#include "relight/transport/surface_gather.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "scene/state_id.h"

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

// Prior of the sun, before the shadows are used; `light` is that of the map alone.
SunPrior PriorOf(const SurveyLight& light) {
  // Of clear skies, whose haze varies, and of the camera's colours. Three real panoramas with much
  // sky, whose disc is not clipped, have 0.14, 0.08 and 0.37.
  constexpr double kHueLogStddev = 0.2;
  // Where the map's disc may be cut or faint, any sun.
  constexpr double kAnySunLogStddev = 1.5;
  constexpr double kAnySunHueLogStddev = 0.24;
  // Behind a building the sky may be covered: about as often as not.
  constexpr double kChanceOfNone = 0.5;
  if (light.sun_origin != SunOrigin::kClearSky) {
    return {light.clear_sky_beam_rgb, kAnySunLogStddev, kAnySunHueLogStddev};
  }
  const double relative =
      MeanOf(light.sun_irradiance_stddev_rgb) / MeanOf(light.sun_irradiance_rgb);
  return {light.clear_sky_beam_rgb,
          std::sqrt(std::max(relative * relative - kHueLogStddev * kHueLogStddev, 0.0)),
          kHueLogStddev,
          light.sun_hidden ? kChanceOfNone : 0.0};
}

// Whether the map's disc holds much less light than its shadows indicate.
bool IsCutShort(const SurveyLight& light, const SunFromShadows& shadows) {
  constexpr double kSignificant = 3.0;
  return MeanOf(light.sun_irradiance_rgb) <
         0.5 * (MeanOf(shadows.irradiance_rgb) - kSignificant * MeanOf(shadows.stddev_rgb));
}

void NoteSun(const std::optional<SunFromShadows>& shadows, SurveyLight& light) {
  if (light.sun_origin == SunOrigin::kShadows && light.sun_irradiance_rgb == glm::dvec3(0.0)) {
    light.notes.push_back(
        "survey map: no sun: surfaces have one albedo where it would shine and in its shade (" +
        std::to_string(shadows->shaded_pixels) + " pixels in its shade in " +
        std::to_string(shadows->comparisons) + " comparisons)");
    return;
  }
  if (light.sun_origin == SunOrigin::kShadows) {
    light.notes.push_back(
        "survey map: the sun is the one under which surfaces have one albedo in "
        "sun and shade (" +
        std::to_string(shadows->shaded_pixels) + " shaded pixels in " +
        std::to_string(shadows->comparisons) + " comparisons)");
  } else if (light.sun_origin == SunOrigin::kClearSky) {
    light.notes.emplace_back(
        "survey map: the sun is taken as the map's sky times the clear-sky beam over diffuse");
  } else {
    return;
  }
  const double relative =
      MeanOf(light.sun_irradiance_stddev_rgb) / std::max(MeanOf(light.sun_irradiance_rgb), 1e-300);
  light.notes.back() += ", +/- " + std::to_string(std::lround(100.0 * relative)) +
                        " %; albedos of what it lit, " +
                        std::to_string(std::lround(100.0 * MeanOf(light.albedo_stddev_rgb))) + " %";
}

void NoteSkyline(const Skyline& skyline, SurveyLight& light) {
  if (skyline.Empty()) return;
  double hidden = 0.0;
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    hidden += SkyTable::SolidAngleSr(cell) * SkyTable::DirectionOfCell(cell).z *
              skyline.hidden[cell] / std::numbers::pi;
  }
  char text[128];
  std::snprintf(text,
                sizeof(text),
                "survey map: things that the mesh lacks hide %.1f %% of the light of an even sky "
                "from level ground",
                100.0 * hidden);
  light.notes.emplace_back(text);
}

void NoteHaze(SurveyLight& light) {
  if (!light.aerosol_optical_depth_500nm) return;
  char text[96];
  std::snprintf(text,
                sizeof(text),
                "survey map: clear skies are taken to be as hazy as its own: %.2f at 500 nm",
                *light.aerosol_optical_depth_500nm);
  light.notes.emplace_back(text);
}

// Root mean square over what may be sampled and saw the entire disc, by solid angle.
glm::dvec3 AlbedoStddev(const SurveyLight& light, const SurfaceView& view) {
  glm::dvec3 sum(0.0);
  double weights = 0.0;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.may_be_sampled.pixels[i] == 0 || !(view.sun_visibility.pixels[i] >= 1.0f)) continue;
    const glm::dvec3 response(SunResponse(view, i, view.sun_direction_enu));
    const glm::dvec3 irradiance =
        light.sky_irradiance_rgb * glm::dvec3(view.sky_response[0].pixels[i]) +
        light.sun_irradiance_rgb * response;
    const glm::dvec3 relative = light.sun_irradiance_stddev_rgb * response / irradiance;
    const int row = static_cast<int>(i) / view.Width();
    const double weight = LatLongPixelSolidAngleSr(row, {view.Width(), view.Height()});
    sum += weight * relative * relative;
    weights += weight;
  }
  return weights > 0.0 ? glm::sqrt(sum / weights) : glm::dvec3(0.0);
}

void MarkSampleable(const PatchScene& scene,
                    const Image<std::int32_t>& face,
                    std::span<const std::uint8_t> patch_is_diffuse,
                    const Gray8Image* mask,
                    Survey& survey) {
  SurfaceView& view = survey.view;
  view.may_be_sampled = Gray8Image(view.Width(), view.Height(), 0);
  for (std::size_t i = 0; i < face.pixels.size(); ++i) {
    if (face.pixels[i] == PatchScene::kSky) continue;
    const auto patch = static_cast<std::size_t>(face.pixels[i]) / 2;
    const bool allowed = patch_is_diffuse[patch] != 0 && !scene.IsExtension(patch) &&
                         (mask == nullptr || mask->pixels[i] == 255);
    view.may_be_sampled.pixels[i] =
        allowed && view.albedo_measured.pixels[i] != 0 && survey.unmodelled_shade.pixels[i] == 0;
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
  if (!(misplacement.turned_rad >= 0.0) || !(misplacement.turned_rad < 0.5)) {
    Refuse("misplacement.turned_rad is " + std::to_string(misplacement.turned_rad),
           "0 or more and less than 0.5");
  }
  if (!(misplacement.moved_m >= 0.0) || !std::isfinite(misplacement.moved_m)) {
    Refuse("misplacement.moved_m is " + std::to_string(misplacement.moved_m), "0 or more metres");
  }
}

std::shared_ptr<const SkyShape> OwnSkyShape(const SurveyLight& light, const Skyline& skyline) {
  return SeenPast(skyline, MakeImageSkyShape("survey", light.sky_radiance));
}

Survey MakeSurvey(const SurveyMap& map,
                  const PatchTransport& transport,
                  const DiffuseParts& diffuse,
                  const SurveyOptions& options,
                  PatchScene& scene) {
  const auto& patch_is_diffuse = diffuse.patch_is_diffuse;
  const Gray8Image* const mask = diffuse.mask;
  map.Validate();
  if (patch_is_diffuse.size() != scene.PatchCount()) {
    throw std::invalid_argument("patch_is_diffuse has " + std::to_string(patch_is_diffuse.size()) +
                                " entries: expected one for each of the " +
                                std::to_string(scene.PatchCount()) + " patches");
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
  Image<std::int32_t> face;
  CastGeometry(scene, rays, 1, view, face);
  for (std::int32_t& shown : face.pixels) {
    if (shown != PatchScene::kSky) shown = scene.FaceOfSide(shown);
  }

  Gray8Image shows_sky(rays.width, rays.height, 0);
  for (int y = 0; y < rays.height; ++y) {
    for (int x = 0; x < rays.width; ++x) {
      const bool free = face.At(x, y) == PatchScene::kSky;
      shows_sky.At(x, y) = free && rays.Direction(face.Index(x, y)).z > 0.0f ? 255 : 0;
    }
  }
  const Gray8Image hidden = FindHiddenSky(map.radiance, shows_sky);
  for (std::size_t i = 0; i < hidden.pixels.size(); ++i) {
    if (hidden.pixels[i] != 0) shows_sky.pixels[i] = 0;
  }
  survey.light =
      MeasureSurveyLight(map, shows_sky, SunSeenFrom(map, scene, options.sun_disc_samples));
  scene.skyline = SkylineOf(map.radiance, hidden, survey.light.sky_irradiance_rgb);
  survey.skyline = scene.skyline;
  NoteSkyline(survey.skyline, survey.light);
  NoteHaze(survey.light);

  const SunDisc disc(
      survey.light.sun_direction_enu, map.sun_angular_radius_rad, options.sun_disc_samples);
  view.sun_visibility = SunVisibility(scene.caster, disc, view);
  Gray8Image edges = MeshEdges(view, rays.origin_m, rays.wraps_x);
  const GrayImage mesh_edge_distance_px = DistanceTo(edges, rays.wraps_x);
  AddShadowEdges(view, view.sun_visibility, rays.wraps_x, edges);
  view.edge_distance_px = DistanceTo(edges, rays.wraps_x);
  view.footprint_radius_px = GrayImage(rays.width, rays.height, 0.5f);
  const Image<ShadowSide> side = FindShadowSides(scene.caster, disc, rays, map.misplacement, view);

  const auto gather =
      std::make_shared<SurfaceGather>(scene, rays, view, options.receiver_block_px, options.gather);
  survey.gather = gather;
  const auto solve = [&] {
    return SolveAlbedo({.radiance = map.radiance,
                        .light = survey.light,
                        .skyline = survey.skyline,
                        .sun_angular_radius_rad = map.sun_angular_radius_rad,
                        .face = face,
                        .side = side,
                        .gather = *gather,
                        .transport = transport,
                        .bounces = options.bounces},
                       scene,
                       view);
  };
  AlbedoResult solved = solve();
  // Albedo, and with it the bounces in the shadows, depend on the sun: the two are found in turn.
  // A stronger sun brightens the shadows, which then ask for a weaker one: part of the way is less
  // than that swings.
  constexpr int kMostTurns = 5;
  constexpr double kPartOfTheWay = 0.65;
  constexpr double kSettled = 5e-3;
  const SunPrior prior = PriorOf(survey.light);
  const bool is_hidden = survey.light.sun_hidden;
  std::optional<SunFromShadows> shadows;
  for (int turn = 0; turn < kMostTurns && survey.light.sun_origin != SunOrigin::kNone; ++turn) {
    shadows = MeasureSunFromShadows({.radiance = map.radiance,
                                     .view = view,
                                     .side = side,
                                     .mesh_edge_distance_px = mesh_edge_distance_px,
                                     .misplacement = map.misplacement,
                                     .origin_m = rays.origin_m,
                                     .face = face,
                                     .scene = scene,
                                     .patch_is_diffuse = patch_is_diffuse,
                                     .mask = mask,
                                     .sky_irradiance_rgb = survey.light.sky_irradiance_rgb,
                                     .prior = prior});
    if (!shadows) break;
    SurveyLight& light = survey.light;
    if (turn == 0 && light.sun_origin == SunOrigin::kMap) {
      if (!IsCutShort(light, *shadows)) break;
      light.notes.emplace_back(
          "survey map: the sun's disc holds less than half of what shadows say: clipped");
      light.sun_clipped = true;
    }
    if (shadows->irradiance_rgb == glm::dvec3(0.0)) {
      // Once more, with the bounces that there are without a sun.
      const bool is_settled = light.sun_irradiance_rgb == glm::dvec3(0.0);
      light.sun_origin = SunOrigin::kShadows;
      light.sun_irradiance_rgb = glm::dvec3(0.0);
      light.sun_irradiance_stddev_rgb = shadows->stddev_rgb;
      light.sun_hidden = false;
      if (is_settled) break;
      solved = solve();
      continue;
    }
    light.sun_hidden = is_hidden;
    // Else the shadows hardly add to the clear sky.
    constexpr double kSharper = 0.7;
    const double relative = MeanOf(shadows->stddev_rgb) / MeanOf(shadows->irradiance_rgb);
    light.sun_origin =
        relative < kSharper * prior.shared_log_stddev ? SunOrigin::kShadows : SunOrigin::kClearSky;
    const glm::dvec3 move = shadows->irradiance_rgb - light.sun_irradiance_rgb;
    light.sun_irradiance_rgb += (turn == 0 ? 1.0 : kPartOfTheWay) * move;
    light.sun_irradiance_stddev_rgb = shadows->stddev_rgb;
    if (!(MeanOf(glm::abs(move)) > kSettled * MeanOf(light.sun_irradiance_rgb))) break;
    solved = solve();
  }
  constexpr double kWorthANote = 1e-3;
  if (solved.last_change > kWorthANote) {
    survey.light.notes.push_back("survey albedo: still moved by " +
                                 std::to_string(solved.last_change) + " after " +
                                 std::to_string(solved.iterations) + " iterations");
  }
  if (solved.on_wrong_side > 0) {
    survey.light.notes.push_back(
        "survey albedo: " + std::to_string(solved.on_wrong_side) +
        " pixels beside shadow edges, which mesh and map place differently, have their surface's");
  }
  UnmodelledShade shade =
      FindUnmodelledShade({.radiance = map.radiance,
                           .view = view,
                           .side = side,
                           .sun_irradiance_rgb = glm::vec3(survey.light.sun_irradiance_rgb),
                           .sky_irradiance_rgb = glm::vec3(survey.light.sky_irradiance_rgb)});
  for (std::size_t i = 0; i < shade.is_in_shade.pixels.size(); ++i) {
    if (shade.is_in_shade.pixels[i] == 0) continue;
    view.albedo_rgb.pixels[i] = glm::min(shade.albedo_rgb.pixels[i], glm::vec3(kLargestAlbedo));
    view.albedo_measured.pixels[i] = 1;
  }
  survey.unmodelled_shade = std::move(shade.is_in_shade);
  if (shade.pixels > 0) {
    survey.light.notes.push_back("survey albedo: " + std::to_string(shade.pixels) +
                                 " pixels lie in shade that the mesh does not cast");
  }
  MarkSampleable(scene, face, patch_is_diffuse, mask, survey);
  survey.light.albedo_stddev_rgb = AlbedoStddev(survey.light, view);
  NoteSun(shadows, survey.light);
  view.geometry_id = StateId::Next();
  view.sky_id = StateId::Next();
  view.sun_id = StateId::Next();
  return survey;
}

}  // namespace pleinair
