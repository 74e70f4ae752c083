// Diffuse samples of a made-up courtyard, with known light and dials for what goes wrong.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_prior.h"
#include "estimation/lighting_source.h"

namespace pleinair::testing {

struct SyntheticScene {
  std::uint64_t seed = 1;
  int samples = 500;
  int regions = 6;  // Each with its own normal and albedo; every second one is ground.
  double lit_share = 0.5;
  bool one_plane = false;  // All samples on one plane, without bounces: sun and sky look alike.

  glm::dvec3 sun{820.0, 780.0, 700.0};
  glm::dvec3 sky{95.0, 110.0, 130.0};

  double albedo_noise = 0.0;   // Relative, grey, per sample: albedo believed against albedo true.
  double channel_noise = 0.0;  // Relative, of each channel by itself.
  double region_noise = 0.0;   // Relative, shared by a plane.
  double tile_noise = 0.0;     // Relative, shared by a plane's pixels in a tile of 120 x 120.
  enum class Outliers { kNone, kRandom, kDarkPatch, kBrightObject, kOneRegion };
  Outliers outliers = Outliers::kNone;
  double outlier_share = 0.0;
  double dark = 0.4;  // Of the radiance that a dark patch should have.
};

inline std::vector<DiffuseSample> MakeSamples(const SyntheticScene& scene) {
  std::mt19937_64 random(scene.seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform;

  struct Region {
    glm::dvec3 albedo;
    double cosine;
    double ambient;
    double error;
    std::array<double, 12> tile_error;
  };
  std::vector<Region> regions;
  for (int r = 0; r < scene.regions; ++r) {
    const bool ground = r % 2 == 0;
    const double grey = 0.15 + 0.45 * uniform(random);
    Region region;
    region.albedo =
        grey * glm::dvec3(1.0, 0.85 + 0.1 * uniform(random), 0.7 + 0.2 * uniform(random));
    region.cosine = ground ? 0.6 : 0.25 + 0.6 * uniform(random);
    region.ambient = ground ? 0.8 : 0.42;
    region.error = scene.region_noise * gauss(random);
    region.tile_error.fill(0.0);
    if (scene.tile_noise > 0.0) {
      for (double& error : region.tile_error) error = scene.tile_noise * gauss(random);
    }
    regions.push_back(region);
  }

  std::vector<DiffuseSample> samples;
  for (int i = 0; i < scene.samples; ++i) {
    const int r = scene.one_plane ? 0 : i % scene.regions;
    const Region& region = regions[static_cast<std::size_t>(r)];
    const bool lit = uniform(random) < scene.lit_share;
    const double ambient = scene.one_plane ? 0.8 : region.ambient * (0.8 + 0.4 * uniform(random));
    const glm::dvec3 bounce_sky = scene.one_plane
                                      ? glm::dvec3(0.0)
                                      : (0.05 + 0.15 * uniform(random)) * glm::dvec3(1.0, 0.9, 0.8);
    const glm::dvec3 bounce_sun = scene.one_plane
                                      ? glm::dvec3(0.0)
                                      : (0.02 + 0.1 * uniform(random)) * glm::dvec3(1.0, 0.9, 0.8);
    const glm::dvec3 reflectance = region.albedo * (0.8 + 0.4 * uniform(random)) / std::numbers::pi;
    const double albedo_error = std::max(0.05, 1.0 + scene.albedo_noise * gauss(random));

    DiffuseSample sample;
    sample.sun_transport_rgb = reflectance * ((lit ? region.cosine : 0.0) + bounce_sun);
    sample.sky_transport_rgb[0] = reflectance * (ambient + bounce_sky);
    sample.radiance_rgb =
        scene.sun * sample.sun_transport_rgb + scene.sky * sample.sky_transport_rgb[0];
    sample.pixel = {(i * 37) % 480, (i * 91) % 360};
    const auto tile = static_cast<std::size_t>(sample.pixel.y / 120 * 4 + sample.pixel.x / 120);
    sample.radiance_rgb *=
        albedo_error * std::max(0.05, 1.0 + region.error + region.tile_error[tile]);
    for (int c = 0; c < 3; ++c) {
      sample.radiance_rgb[c] *= std::max(0.05, 1.0 + scene.channel_noise * gauss(random));
    }
    sample.is_lit = lit;
    sample.plane = r;

    bool wrong = false;
    switch (scene.outliers) {
      case SyntheticScene::Outliers::kNone:
        break;
      case SyntheticScene::Outliers::kRandom:
        wrong = uniform(random) < scene.outlier_share;
        if (wrong) sample.radiance_rgb *= std::exp(2.0 * gauss(random));
        break;
      case SyntheticScene::Outliers::kDarkPatch:  // Wet, or in a shadow that the mesh lacks.
        wrong = uniform(random) < scene.outlier_share;
        if (wrong) sample.radiance_rgb *= scene.dark;
        break;
      case SyntheticScene::Outliers::kBrightObject:  // One white van.
        wrong = uniform(random) < scene.outlier_share;
        if (wrong)
          sample.radiance_rgb = glm::dvec3(260.0, 262.0, 258.0) * (1.0 + 0.02 * gauss(random));
        break;
      case SyntheticScene::Outliers::kOneRegion:
        wrong = r == 0 && uniform(random) < scene.outlier_share * scene.regions;
        if (wrong) sample.radiance_rgb *= glm::dvec3(2.2, 1.2, 0.6);
        break;
    }
    samples.push_back(sample);
  }
  return samples;
}

// One problem whose samples cannot separate sun and sky, and one of the same light whose samples
// can.
struct ProblemPair {
  SyntheticScene degenerate;
  SyntheticScene sound;
};

inline ProblemPair MakeProblemPair(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  SyntheticScene scene;
  scene.seed = random();
  scene.samples = 20 + static_cast<int>(uniform(random) * 100.0);
  scene.albedo_noise = 0.1 * uniform(random);
  scene.sun *= uniform(random) < 0.3 ? 0.0 : uniform(random);
  scene.sky *= 0.5 + 2.0 * uniform(random);
  ProblemPair pair{scene, scene};
  pair.degenerate.one_plane = true;
  pair.degenerate.lit_share = uniform(random) < 0.5 ? 0.0 : 1.0;
  pair.sound.lit_share = 0.2 + 0.6 * uniform(random);
  return pair;
}

// A clear sky in the scene's units: the beam of SyntheticScene's sun, a little above it.
inline ClearSkyExpectation SyntheticClearSky() {
  return {.beam_rgb = {850.0, 800.0, 720.0},
          .diffuse_rgb = {70.0, 85.0, 100.0},
          .sine_of_elevation = 0.6,
          .absolute = true};
}

inline LightingPrior SyntheticPrior() { return MakeClimatePrior(SyntheticClearSky(), 1); }

}  // namespace pleinair::testing
