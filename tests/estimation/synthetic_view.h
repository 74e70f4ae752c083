// A made-up picture and its model: ground with a wall behind it, a shadow across both.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "estimation/lighting_source.h"
#include "scene/state_id.h"
#include "scene/surface_view.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::testing {

// From the south-west, 45 degrees high.
inline glm::dvec3 SyntheticSunDirection() { return glm::normalize(glm::dvec3(-0.5, -0.5, 0.7071)); }

struct SyntheticPicture {
  int width = 160;
  int height = 120;
  double shadow_share = 0.5;  // Of the picture's width, from the left; 0 and 1 have no edge.
  glm::dvec3 sun{820.0, 780.0, 700.0};
  glm::dvec3 sky{95.0, 110.0, 130.0};
  double noise = 0.0;  // Relative, per pixel and channel.
  std::uint64_t seed = 1;
};

// Upper half a wall that faces south, lower half ground. Sky response 0.45 and 0.85, bounces 0.08
// of sun (brown) and 0.1 of sky. Albedos vary by 20 % from pixel to pixel.
inline SurfaceView MakeView(const SyntheticPicture& picture) {
  const int width = picture.width;
  const int height = picture.height;
  SurfaceView view;
  view.camera.intrinsics = {width, height, 100.0, 100.0, width / 2.0, height / 2.0, {}};
  view.region_names = {"wall", "ground"};
  view.region = Image<std::int32_t>(width, height, 0);
  view.position_world_m = Image<glm::vec3>(width, height);
  view.normal_world = Image<glm::vec3>(width, height);
  view.albedo_rgb = Image<glm::vec3>(width, height);
  view.albedo_measured = Image<std::uint8_t>(width, height, 1);
  view.may_be_sampled = Image<std::uint8_t>(width, height, 1);
  view.sky_shape_names = {"uniform"};
  view.sky_response.assign(1, Image<glm::vec3>(width, height));
  view.sun_visibility = Image<float>(width, height);
  view.sun_bounce = Image<glm::vec3>(width, height);
  view.edge_distance_px = Image<float>(width, height);
  view.footprint_radius_px = Image<float>(width, height, 1.2f);
  view.sun_direction_enu = SyntheticSunDirection();
  view.geometry_id = StateId::Next();
  view.sky_id = StateId::Next();
  view.sun_id = StateId::Next();

  std::mt19937_64 random(7);
  std::uniform_real_distribution<float> uniform(0.8f, 1.2f);
  const int shadow_end = static_cast<int>(picture.shadow_share * width);
  const int wall_end = height / 2;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool wall = y < wall_end;
      view.region.At(x, y) = wall ? 0 : 1;
      view.normal_world.At(x, y) = wall ? glm::vec3(0, -1, 0) : glm::vec3(0, 0, 1);
      view.albedo_rgb.At(x, y) =
          (wall ? glm::vec3(0.45f, 0.3f, 0.22f) : glm::vec3(0.3f, 0.3f, 0.28f)) * uniform(random);
      view.sky_response[0].At(x, y) =
          glm::vec3(wall ? 0.45f : 0.85f) + 0.1f * glm::vec3(1.0f, 0.9f, 0.8f);
      view.sun_visibility.At(x, y) = x < shadow_end ? 0.0f : 1.0f;
      view.sun_bounce.At(x, y) = 0.08f * glm::vec3(1.0f, 0.8f, 0.6f);
      int distance = std::min({x, y, width - 1 - x, height - 1 - y});
      distance = std::min(distance, wall ? wall_end - 1 - y : y - wall_end);
      if (shadow_end > 0 && shadow_end < width) {
        distance = std::min(distance, x < shadow_end ? shadow_end - 1 - x : x - shadow_end);
      }
      view.edge_distance_px.At(x, y) = static_cast<float>(distance);
    }
  }
  return view;
}

// What a camera sees of `view` under the picture's light.
inline Frame MakeFrame(const SyntheticPicture& picture, const SurfaceView& view) {
  Frame frame;
  frame.time = UtcTime{std::chrono::hours(12)};
  frame.camera = view.camera;
  frame.radiance = RgbImage(picture.width, picture.height);
  frame.unusable = Gray8Image(picture.width, picture.height, 0);
  frame.clipped = Gray8Image(picture.width, picture.height, 0);
  std::mt19937_64 random(picture.seed);
  std::normal_distribution<double> gauss;
  for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
    const double cosine =
        std::max(0.0, glm::dot(glm::dvec3(view.normal_world.pixels[i]), view.sun_direction_enu));
    const glm::dvec3 response =
        glm::dvec3(view.sun_bounce.pixels[i]) + double{view.sun_visibility.pixels[i]} * cosine;
    glm::dvec3 radiance =
        glm::dvec3(view.albedo_rgb.pixels[i]) / std::numbers::pi *
        (picture.sun * response + picture.sky * glm::dvec3(view.sky_response[0].pixels[i]));
    for (int c = 0; c < 3; ++c) radiance[c] *= 1.0 + picture.noise * gauss(random);
    frame.radiance.pixels[i] = glm::vec3(radiance);
  }
  return frame;
}

inline LightingObservation Observe(const Frame& frame, const SurfaceView& view) {
  return {frame, view, {view.sun_direction_enu}, SyntheticClearSky()};
}

}  // namespace pleinair::testing
