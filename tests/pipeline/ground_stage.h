// A level ground under a given sun and an even sky, for objects to stand on: quick to prepare.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair {

// The same sun and sky in every frame.
class StillLight : public LightingSource {
 public:
  static constexpr double kSun = 400.0;
  static constexpr double kSky = 100.0;

  explicit StillLight(double sun = kSun, double sky = kSky)
      : StillLight(glm::dvec3(sun), glm::dvec3(sky)) {}
  StillLight(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb)
      : sun_rgb_(sun_rgb), sky_rgb_(sky_rgb) {}

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame&, const SunState&) override {
    return SkyBasis(shapes_);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    LightingEstimate estimate;
    estimate.lighting.sun.direction_enu = observation.sun.direction_enu;
    estimate.lighting.sun.irradiance_rgb = sun_rgb_;
    estimate.lighting.sky = {{"uniform", sky_rgb_}};
    return estimate;
  }

 private:
  glm::dvec3 sun_rgb_;
  glm::dvec3 sky_rgb_;
  std::vector<std::shared_ptr<const SkyShape>> shapes_{MakeUniformSkyShape()};
};

class GroundStage {
 public:
  static constexpr double kAlbedo = 0.4;

  // With a wall in the east, tall enough to keep the sun off all that is near the origin, if so
  // asked.
  explicit GroundStage(bool has_wall = false)
      : GroundStage(has_wall ? std::optional(Block{{3.0f, -7.0f, 0.0f}, {3.4f, 7.0f, 9.0f}})
                             : std::nullopt) {}

  struct Block {
    glm::vec3 lower_m{0.0f};
    glm::vec3 upper_m{0.0f};
  };
  // With something that stands on it.
  explicit GroundStage(const std::optional<Block>& block) {
    AddGround(site_.mesh, 8.0f);
    if (block) AddBox(site_.mesh, block->lower_m, block->upper_m);
    site_.mesh.materials = {
        {.name = "ground", .diffuse_albedo = glm::vec3(static_cast<float>(kAlbedo))}};
    site_.mesh.group_names = {"ground"};
    PrepareOptions options;
    options.gather.rays_per_receiver = 16;
    options.patches.patch_size_m = 2.0;
    options.probes.rays_per_probe = 64;
    options.probe_box = {{-2.0f, -2.0f, 0.1f}, {2.0f, 2.0f, 2.0f}};
    options.probe_counts = {3, 3, 2};
    KeepsNothing store;
    scene_ = PrepareScene(site_, options, store, [](auto, auto) {});
  }

  // From the south, 30 degrees down on the origin; the sun stands 45 degrees high in the east.
  Frame MakeFrame(double sun = StillLight::kSun, double sky = StillLight::kSky) const {
    Frame frame;
    frame.camera.intrinsics = {96, 72, 100.0, 100.0, 47.5, 35.5, {}};
    const glm::dvec3 eye(0.0, -5.2, 3.0);
    const glm::dvec3 forward = glm::normalize(-eye);
    const glm::dvec3 right(1.0, 0.0, 0.0);
    const glm::dvec3 down = glm::cross(forward, right);
    const glm::dmat3 world_from_camera(right, down, forward);
    frame.camera.camera_from_world =
        glm::dmat4(glm::transpose(world_from_camera)) * glm::translate(glm::dmat4(1.0), -eye);
    frame.sun_direction_enu = glm::normalize(glm::dvec3(1.0, 0.0, 1.0));
    // Open ground in the sun.
    const double ground = kAlbedo * std::numbers::inv_pi * (sky + sun * frame.sun_direction_enu->z);
    frame.radiance = RgbImage(96, 72, glm::vec3(static_cast<float>(ground)));
    frame.unusable = Gray8Image(96, 72, 0);
    frame.clipped = Gray8Image(96, 72, 0);
    return frame;
  }

  // Results of one frame for each list of poses, through one pipeline; `apart_s` from one to the
  // next.
  std::vector<FrameResult> Run(const std::vector<VirtualObject>& objects,
                               const FramePipelineOptions& options,
                               const std::vector<std::vector<glm::dmat4>>& poses = {{}},
                               double apart_s = 0.0) const {
    const HeadlessContext context;
    Compositor compositor;
    FramePipeline pipeline({scene_, site_.mesh, std::nullopt, objects},
                           std::make_unique<StillLight>(),
                           compositor,
                           options);
    std::vector<FrameResult> results;
    results.reserve(poses.size());
    for (const std::vector<glm::dmat4>& of_frame : poses) {
      Frame frame = MakeFrame();
      frame.time += std::chrono::nanoseconds(
          std::llround(1e9 * apart_s * static_cast<double>(results.size())));
      results.push_back(pipeline.Process(frame, of_frame).value());
    }
    return results;
  }

  // One frame with one object and all effects.
  FrameResult Process(const Frame& frame,
                      std::unique_ptr<LightingSource> light,
                      const VirtualObject& object,
                      FramePipelineOptions options,
                      Compositor& compositor) const {
    options.effects = EffectSettings::Everything();
    FramePipeline pipeline(
        {scene_, site_.mesh, std::nullopt, {object}}, std::move(light), compositor, options);
    return pipeline.Process(frame).value();
  }

  // Few rays and no filter.
  static FramePipelineOptions QuickOptions() {
    FramePipelineOptions options;
    options.object_light.gather.rays_per_receiver = 32;
    options.influence.rays_per_receiver = 64;
    options.influence.least_spacing = 0.2;
    options.filter.reset();
    return options;
  }

  const PreparedScene& Scene() const { return scene_; }
  const Mesh& Phantom() const { return site_.mesh; }

 private:
  SiteModel site_;
  PreparedScene scene_;
};

// A smooth ball of `rings` rings from pole to pole.
inline VirtualObject BallObject(const glm::vec3& centre_m,
                                float radius_m,
                                int rings,
                                const Material& material) {
  Mesh mesh;
  const int around = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    const float angle =
        std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
    for (int i = 0; i < around; ++i) {
      const float azimuth =
          2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(around);
      const glm::vec3 normal(std::sin(angle) * std::cos(azimuth),
                             std::sin(angle) * std::sin(azimuth),
                             std::cos(angle));
      mesh.positions_m.push_back(centre_m + radius_m * normal);
      mesh.normals.push_back(normal);
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      const auto above = static_cast<std::uint32_t>(ring * around + i);
      const auto next = static_cast<std::uint32_t>(ring * around + (i + 1) % around);
      const auto row = static_cast<std::uint32_t>(around);
      // Triangles at a pole would have no area.
      if (ring > 0) mesh.triangles.emplace_back(above, above + row, next);
      if (ring + 1 < rings) mesh.triangles.emplace_back(next, above + row, next + row);
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.materials = {material};
  mesh.group_names = {"ball"};
  return {std::move(mesh)};
}

inline VirtualObject BoxObject(const glm::vec3& lower_m,
                               const glm::vec3& upper_m,
                               const Material& material) {
  Mesh mesh;
  AddBox(mesh, lower_m, upper_m);
  mesh.materials = {material};
  mesh.group_names = {"box"};
  return {std::move(mesh)};
}

}  // namespace pleinair
