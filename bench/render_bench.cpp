// Time of one composite in software OpenGL: the courtyard's statue (3602 triangles, or cut to four
// times as many) under a moving sun, effect by effect, in two picture sizes. The view's responses
// are constants: they cost the same.
#include <cmath>
#include <filesystem>
#include <numbers>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "bench/cut_mesh.h"
#include "objects/object_view.h"
#include "objects/soft_sun.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "scene/mesh_io.h"
#include "scene/ray_caster.h"

namespace pleinair {
namespace {

enum Effects : int {
  kProbesOnly = 0,
  kSunWithoutShadow = 1,
  kVolumes = 2,
  kVolumesSunUnmoved = 3,
  kPenumbra = 4,         // Rays for each frame's sun, from a camera that stands still.
  kPenumbraNewView = 5,  // And for each frame's view of the objects.
  kPenumbraSunUnmoved = 6
};

struct Courtyard {
  Mesh scene;
  Mesh object;
  SurfaceView view;
  RgbImage radiance;
  Gray8Image clipped;
  std::vector<std::vector<glm::vec3>> vertex_irradiance;
};

glm::dvec3 SunAt(double seconds) {
  const double azimuth = std::numbers::pi * (1.0 + seconds / 43200.0);
  const double elevation = 0.75;
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

Courtyard MakeCourtyard(const std::filesystem::path& sequence, double scale, bool fine) {
  Courtyard yard;
  yard.scene = LoadMesh(sequence / "scene.obj").mesh;
  // Columns; as sequence.json says.
  const glm::dmat4 world_from_object(glm::dvec4(0.9563047289848328, 0.29237186908721924, 0.0, 0.0),
                                     glm::dvec4(-0.29237186908721924, 0.9563047289848328, 0.0, 0.0),
                                     glm::dvec4(0.0, 0.0, 1.0, 0.0),
                                     glm::dvec4(-1.916210651397705, -1.6906025409698486, 0.0, 1.0));
  yard.object = TransformMesh(world_from_object, LoadMesh(sequence / "object.obj").mesh);
  if (fine) yard.object = CutInFour(yard.object, yard.object.triangles.size());
  Camera& camera = yard.view.camera;
  const auto width = static_cast<int>(480 * scale);
  const auto height = static_cast<int>(360 * scale);
  camera.intrinsics = {
      width, height, 375.0 * scale, 375.0 * scale, 0.5 * (width - 1), 0.5 * (height - 1), {}};
  camera.camera_from_world = glm::transpose(glm::dmat4(
      glm::dvec4(0.5296591295268073, -0.8482106033853087, 0.0, -0.062134551464731125),
      glm::dvec4(
          -0.04589491154611973, -0.028658752772378268, -0.9985350935163497, 1.762505334221344),
      glm::dvec4(0.8469680541729088, 0.5288832084631371, -0.05410792008841638, 9.981468936598992),
      glm::dvec4(0.0, 0.0, 0.0, 1.0)));
  const CameraIntrinsics& k = camera.intrinsics;
  SurfaceView& view = yard.view;
  view.region = Image<std::int32_t>(width, height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(width, height);
  view.normal_world = RgbImage(width, height);
  view.albedo_rgb = RgbImage(width, height);
  view.albedo_measured = Gray8Image(width, height, 1);
  view.may_be_sampled = Gray8Image(width, height, 1);
  view.sky_response = {RgbImage(width, height)};
  view.sun_visibility = GrayImage(width, height);
  view.sun_bounce = RgbImage(width, height);
  view.edge_distance_px = GrayImage(width, height, 10.0f);
  view.footprint_radius_px = GrayImage(width, height, 1.0f);
  yard.radiance = RgbImage(width, height, glm::vec3(100.0f));
  yard.clipped = Gray8Image(width, height, 0);
  const RayCaster caster(yard.scene);
  const glm::vec3 eye(camera.CentreWorldM());
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 direction(glm::normalize(
          world_from_camera * glm::dvec3((x - k.cx_px) / k.fx_px, (y - k.cy_px) / k.fy_px, 1.0)));
      const auto hit = caster.Intersect(eye, direction);
      if (!hit) continue;
      const std::size_t pixel = view.region.Index(x, y);
      view.region.pixels[pixel] = 0;
      view.position_world_m.pixels[pixel] = hit->position_m;
      view.normal_world.pixels[pixel] = hit->geometric_normal;
      view.albedo_rgb.pixels[pixel] = glm::vec3(0.4f);
      view.sky_response[0].pixels[pixel] = glm::vec3(0.8f);
      view.sun_visibility.pixels[pixel] = 1.0f;
    }
  }
  yard.vertex_irradiance = {
      std::vector<glm::vec3>(yard.object.positions_m.size(), glm::vec3(150.0f))};
  return yard;
}

void BM_Composite(benchmark::State& state) {
  const auto effects = static_cast<Effects>(state.range(1));
  const std::filesystem::path sequence =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";
  if (!std::filesystem::exists(sequence)) {
    state.SkipWithError("the recorded sequences are not here");
    return;
  }
  const Courtyard yard =
      MakeCourtyard(sequence, static_cast<double>(state.range(0)) / 480.0, state.range(2) != 0);
  const HeadlessContext context;
  Compositor compositor;
  compositor.SetPhantom(yard.scene);
  compositor.SetObjects({{yard.object}});
  Lighting lighting;
  lighting.sky = {{"uniform", glm::dvec3(120.0)}};
  CompositeInput input{
      yard.radiance, yard.clipped, yard.view, lighting, yard.vertex_irradiance, {}};
  input.effects.sun_shadow = input.effects.object_shadow = effects >= kVolumes;
  PatchScene objects;
  objects.mesh = yard.object;
  objects.caster = RayCaster(objects.mesh);
  const RayCaster real(yard.scene);
  const SoftSun soft_sun(real, objects);
  ObjectView object_view = SeeObjects(objects, yard.view.camera);
  SunShares shares;
  const auto cast_shares = [&] {
    if (effects < kPenumbra) return;
    if (effects == kPenumbraNewView) object_view = SeeObjects(objects, yard.view.camera);
    shares = {soft_sun.OnReal(yard.view, lighting.sun),
              soft_sun.OnObjects(object_view, lighting.sun)};
    input.sun_shares = &shares;
  };
  input.effects.sun_shading = effects >= kSunWithoutShadow;
  lighting.sun.irradiance_rgb = effects == kProbesOnly ? glm::dvec3(0.0) : glm::dvec3(800.0);
  // Software OpenGL compiles on first use.
  for (int i = 0; i < 3; ++i) {
    lighting.sun.direction_enu = SunAt(-1.0 - i);
    cast_shares();
    compositor.Render(input);
  }
  double seconds = 0.0;
  double draw_ms = 0.0;
  double readback_ms = 0.0;
  std::size_t scaled = 0;
  std::size_t covered = 0;
  for (auto _ : state) {
    lighting.sun.direction_enu = SunAt(seconds);
    const bool sun_moves = effects != kVolumesSunUnmoved && effects != kPenumbraSunUnmoved;
    if (sun_moves) {
      seconds += 1.0;
      cast_shares();
    }
    const Composite composite = compositor.Render(input);
    draw_ms += composite.draw_ms;
    readback_ms += composite.readback_ms;
  }
  for (const std::uint8_t change : compositor.Render(input).change.pixels) {
    scaled += change == static_cast<std::uint8_t>(PixelChange::kScaled) ? 1 : 0;
    covered += change == static_cast<std::uint8_t>(PixelChange::kCovered) ? 1 : 0;
  }
  const auto frames = static_cast<double>(state.iterations());
  state.counters["draw_ms"] = draw_ms / frames;
  state.counters["readback_ms"] = readback_ms / frames;
  state.counters["scaled_px"] = static_cast<double>(scaled);
  state.counters["covered_px"] = static_cast<double>(covered);
}

enum RayCastPart : int { kObjectView = 0, kOnObjects = 1, kOnReal = 2 };

// The parts of a penumbra by rays.
void BM_SoftSun(benchmark::State& state) {
  const std::filesystem::path sequence =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";
  if (!std::filesystem::exists(sequence)) {
    state.SkipWithError("the recorded sequences are not here");
    return;
  }
  const Courtyard yard = MakeCourtyard(sequence, 640.0 / 480.0, state.range(1) != 0);
  PatchScene objects;
  objects.mesh = yard.object;
  objects.caster = RayCaster(objects.mesh);
  const RayCaster real(yard.scene);
  const SoftSun soft_sun(real, objects);
  const ObjectView object_view = SeeObjects(objects, yard.view.camera);
  double seconds = 0.0;
  for (auto _ : state) {
    seconds += 1.0;
    const DirectionalLight sun{SunAt(seconds), {}, kMeanSunAngularRadiusRad};
    if (state.range(0) == kObjectView) {
      benchmark::DoNotOptimize(SeeObjects(objects, yard.view.camera));
    } else if (state.range(0) == kOnObjects) {
      benchmark::DoNotOptimize(soft_sun.OnObjects(object_view, sun));
    } else {
      benchmark::DoNotOptimize(soft_sun.OnReal(yard.view, sun));
    }
  }
}

BENCHMARK(BM_SoftSun)
    ->ArgNames({"part", "fine"})
    ->ArgsProduct({{kObjectView, kOnObjects, kOnReal}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// Picture width (480x360, 640x480), effects, whether the object has four times the faces.
BENCHMARK(BM_Composite)
    ->ArgNames({"width", "effects", "fine"})
    ->ArgsProduct({{480, 640},
                   {kProbesOnly,
                    kSunWithoutShadow,
                    kVolumes,
                    kVolumesSunUnmoved,
                    kPenumbra,
                    kPenumbraNewView,
                    kPenumbraSunUnmoved},
                   {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();
