#include "pipeline/internal/effects/bound_terms.h"

#include <vector>

#include <glm/common.hpp>

#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/real_pixels.h"
#include "scene/is_finite.h"

namespace pleinair {
namespace {

// A face's corners bound what lies between them: light at the vertices is interpolated.
double SunOnFaces(const PatchScene& objects, const EffectFrame& frame) {
  const Mesh& mesh = objects.mesh;
  const glm::vec3 sun = SunOf(frame.lighting);
  const glm::vec3 to_sun(frame.lighting.sun.direction_enu);
  std::vector<glm::vec3> irradiance;
  for (const std::vector<glm::vec3>& of_object : frame.light.irradiance) {
    irradiance.insert(irradiance.end(), of_object.begin(), of_object.end());
  }
  const auto white = static_cast<float>(1.0 / frame.codes.Exposure());
  const auto on_face = [&](std::size_t t) {
    const glm::uvec3& corners = mesh.triangles[t];
    float cosine = 0.0f;
    float least_dot = 1.0f;
    for (int k = 0; k < 3; ++k) {
      const glm::vec3& normal = mesh.normals[corners[k]];
      // Faces may be seen from either side.
      cosine = std::max(cosine, std::abs(glm::dot(normal, to_sun)));
      least_dot = std::min(least_dot, glm::dot(normal, mesh.normals[corners[(k + 1) % 3]]));
    }
    // Between normals whose angles' cosines are at least c the interpolated one is sqrt((1 + 2 c)
    // / 3) long at least, and is given its length back.
    const float length = std::sqrt(std::max((1.0f + 2.0f * least_dot) / 3.0f, 1e-6f));
    cosine = std::min(cosine / length, 1.0f);
    const Material& material = mesh.materials[mesh.triangle_material[t]];
    const glm::vec3 least =
        glm::min(glm::min(irradiance[corners.x], irradiance[corners.y]), irradiance[corners.z]);
    const glm::vec3 without = glm::max(least, glm::vec3(0.0f));
    glm::vec3 to_radiance = kInvPi * material.diffuse_albedo;
    if (material.by_place) {
      // Some place of the texture may be as bright as that, or just not white: a brighter one shows
      // less of the rise.
      to_radiance = glm::min(kInvPi * BrightestOf(material).diffuse_albedo,
                             white / glm::max(without + cosine * sun, glm::vec3(1e-30f)));
    }
    return frame.codes.LargestRise(to_radiance * without, to_radiance * cosine * sun);
  };
  // Some faces first: they may already exceed the threshold.
  const std::size_t step = StepOverFew(mesh.triangles.size());
  for (std::size_t t = step / 2; t < mesh.triangles.size(); t += step) {
    if (on_face(t) > kFarAbove * frame.threshold_code_values) return kWhiteCode;
  }
  return static_cast<double>(LargestOver(mesh.triangles.size(), on_face));
}

}  // namespace

double ChangeOfReached(const EffectFrame& frame,
                       const InfluenceReach& reach,
                       const glm::vec3& hidden,
                       const glm::vec3& added) {
  return static_cast<double>(LargestOver(reach.pixels.size(), [&](std::size_t i) {
    const std::size_t pixel = reach.pixels[i];
    const glm::vec3& camera = frame.radiance.pixels[pixel];
    if (!IsFinite(camera)) return 0.0f;
    const PixelLight light = LightOfPixel(frame, pixel);
    const glm::vec3 to_radiance = kInvPi * frame.view.albedo_rgb.pixels[pixel];
    const bool clipped = IsClipped(frame.frame, pixel);
    const glm::vec3 without =
        clipped ? glm::max(camera, to_radiance * (light.indirect + light.direct)) : camera;
    glm::vec3 less = without;
    glm::vec3 more = without;
    for (int c = 0; c < 3; ++c) {
      // RelitRadiance's value, or more.
      const bool is_possible = without[c] < kInvPi * light.indirect[c];
      more[c] += (is_possible ? without[c] / light.indirect[c] : kInvPi) * added[c];
      if (!(light.indirect[c] > 0.0f)) continue;
      less[c] *= std::max(1.0f - hidden[c] / light.indirect[c], 0.0f);
    }
    return std::max(CodesBetween(frame, pixel, without, less),
                    CodesBetween(frame, pixel, without, more));
  }));
}

Bound LightOnObjects(EffectStage& stage, const EffectFrame& frame) {
  if (!stage.InView(frame)) return {0.0, "no object in view"};
  const glm::vec3 irradiance = stage.LargestIrradianceOnObjects(frame);
  if (IsDark(irradiance)) return {0.0, "no light"};
  return {frame.codes.LargestRise(glm::vec3(0.0f), kInvPi * stage.LargestAlbedo() * irradiance),
          "all light in the scene on a white object"};
}

Bound SunOnObjects(EffectStage& stage, const EffectFrame& frame) {
  const glm::vec3 sun = SunOf(frame.lighting);
  if (IsDark(sun)) return {0.0, "no sun"};
  if (!stage.InView(frame)) return {0.0, "no object in view"};
  if (stage.AnyGlossy()) return {kWhiteCode, "glint of the sun on a glossy object"};
  const Bound on_black{
      frame.codes.LargestRise(glm::vec3(0.0f), kInvPi * stage.LargestDiffuse() * sun),
      "sun on a black object"};
  if (on_black.code_values <= frame.threshold_code_values || frame.light.irradiance.empty()) {
    return on_black;
  }
  return {std::min(on_black.code_values, SunOnFaces(stage.Objects(), frame)),
          "sun on top of the current light"};
}

}  // namespace pleinair
