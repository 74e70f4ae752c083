#include "pipeline/internal/effect_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "objects/mirror_image.h"
#include "render/real_sun.h"
#include "scene/textured_material.h"

namespace pleinair {
namespace {

constexpr float kInvPi = std::numbers::inv_pi_v<float>;
// Bounds this many times above the threshold are not looked into.
constexpr double kFarAbove = 4.0;

// Share of a vertex's view from which on what objects hide from themselves is seen under any sky.
constexpr float kMostHidden = 0.02f;

// To look at some 256 of `count` before all.
std::size_t StepOverFew(std::size_t count) { return (count + 255) / 256; }

bool IsDark(const glm::vec3& light) { return !glm::any(glm::greaterThan(light, glm::vec3(0.0f))); }

bool IsFinite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::vec3 SunOf(const Lighting& lighting) { return glm::vec3(lighting.sun.irradiance_rgb); }

// The model's light of a real pixel without virtual objects.
struct PixelLight {
  glm::vec3 indirect{0.0f};
  glm::vec3 direct{0.0f};  // With all of the disc seen.
};

PixelLight LightOfPixel(const BoundInput& input, std::size_t pixel) {
  const SurfaceView& view = input.view;
  const glm::vec3 sun = SunOf(input.lighting);
  PixelLight light;
  light.indirect = sun * view.sun_bounce.pixels[pixel];
  for (std::size_t k = 0; k < view.sky_response.size(); ++k) {
    light.indirect +=
        glm::vec3(input.lighting.sky[k].irradiance_rgb) * view.sky_response[k].pixels[pixel];
  }
  const glm::vec3 to_sun(input.lighting.sun.direction_enu);
  light.direct = sun * std::max(glm::dot(view.normal_world.pixels[pixel], to_sun), 0.0f);
  return light;
}

bool IsClipped(const Frame& frame, std::size_t pixel) {
  return !frame.clipped.Empty() && frame.clipped.pixels[pixel] != 0;
}

// Code values by which a real pixel falls when all of the sun that it sees is taken away, where
// objects may hide that share of its other light: in the dark a step of light is more codes.
float FallInShadow(const BoundInput& input, std::size_t pixel, float hidden_share) {
  const SurfaceView& view = input.view;
  const glm::vec3& camera = input.frame.radiance.pixels[pixel];
  if (!IsFinite(camera)) return 0.0f;
  const PixelLight light = LightOfPixel(input, pixel);
  const glm::vec3 to_radiance = kInvPi * view.albedo_rgb.pixels[pixel];
  RealPixel state;
  state.observed = camera;
  state.clipped = IsClipped(input.frame, pixel);
  state.lit = to_radiance * (light.indirect + light.direct);
  state.shaded = to_radiance * light.indirect;
  state.model_visibility = view.sun_visibility.pixels[pixel];
  state.edge_distance_px = view.edge_distance_px.pixels[pixel];
  state.albedo_measured = view.albedo_measured.pixels[pixel] != 0;
  const int width = view.Width();
  const auto place = static_cast<int>(pixel);
  const float seen = SunSeenWithout(
      state, {input.frame.radiance, input.frame.clipped, view}, place % width, place / width);
  if (seen <= 0.0f) return 0.0f;
  const glm::vec3 before = light.indirect + seen * light.direct;
  const glm::vec3 without = state.clipped ? glm::max(camera, to_radiance * before) : camera;
  glm::vec3 after = without;
  for (int c = 0; c < 3; ++c) {
    if (before[c] > 0.0f) after[c] = without[c] * light.indirect[c] / before[c];
  }
  const glm::vec3 hidden = hidden_share * after;
  return input.codes.Difference(without - hidden, after - hidden);
}

// Of any place of it.
TexturedMaterial::Reflectances BrightestOf(const Material& material) {
  if (material.by_place) return material.by_place->Brightest();
  return {material.diffuse_albedo, material.specular_reflectance};
}

template <class Value>
float LargestOver(std::size_t count, const Value& value) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, 1024),
      0.0f,
      [&](const tbb::blocked_range<std::size_t>& range, float largest) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          largest = std::max(largest, value(i));
        }
        return largest;
      },
      [](float a, float b) { return std::max(a, b); });
}

}  // namespace

EffectBounds::EffectBounds(const RayCaster& real_caster,
                           const PatchScene& objects,
                           const SoftSun& soft_sun,
                           const glm::vec3& scene_albedo)
    : real_caster_(real_caster),
      objects_(objects),
      soft_sun_(soft_sun),
      scene_albedo_(scene_albedo) {}

void EffectBounds::ObjectsMoved() {
  Forget();
  object_diffuse_ = object_albedo_ = glm::vec3(0.0f);
  any_glossy_ = false;
  for (const Material& material : objects_.mesh.materials) {
    const TexturedMaterial::Reflectances shown = BrightestOf(material);
    any_glossy_ = any_glossy_ || shown.specular_reflectance != glm::vec3(0.0f);
    object_diffuse_ = glm::max(object_diffuse_, shown.diffuse_albedo);
    object_albedo_ =
        glm::max(object_albedo_,
                 glm::min(shown.diffuse_albedo + shown.specular_reflectance, glm::vec3(1.0f)));
  }
}

void EffectBounds::Forget() {
  in_view_version_.reset();
  sun_version_.reset();
  reach_version_.reset();
  near_shadow_version_.reset();
}

bool EffectBounds::InView(const SurfaceView& view) {
  if (in_view_version_ != view.geometry_version) {
    in_view_ = MayBeInView(objects_, view.camera);
    in_view_version_ = view.geometry_version;
  }
  return in_view_;
}

bool EffectBounds::SunReachesObjects(const FrameBasis& basis) {
  if (sun_version_ != basis.Version(0)) {
    sun_reaches_ = AnySeesSun(objects_, real_caster_, basis.Sun());
    sun_version_ = basis.Version(0);
  }
  return sun_reaches_;
}

const InfluenceReach& EffectBounds::Reach(const SurfaceView& view) {
  if (reach_version_ != view.geometry_version) {
    reach_ = ReachOfInfluence(objects_, view);
    reach_version_ = view.geometry_version;
  }
  return reach_;
}

glm::vec3 EffectBounds::LargestIrradiance(const BoundInput& input) const {
  // Close to objects a real face's own place may be in the sun where the face's mean is not.
  glm::vec3 largest = scene_albedo_ * SunOf(input.lighting);
  for (std::size_t light = 0; light < input.basis.LightCount(); ++light) {
    largest += IntensityOf(input.lighting, light) * input.basis.LargestIrradiance(light);
  }
  return largest;
}

glm::vec3 EffectBounds::LargestIrradianceOnObjects(const BoundInput& input) const {
  const glm::vec3 of_scene = LargestIrradiance(input);
  // One reflection off an object, and one off what that is reflected from.
  const glm::vec3 of_objects = object_albedo_ * (of_scene + SunOf(input.lighting));
  return glm::max(of_scene, of_objects) + object_albedo_ * of_objects;
}

Bound EffectBounds::ProbeShading(const BoundInput& input) {
  if (!InView(input.view)) return {0.0, "no object in view"};
  const glm::vec3 irradiance = LargestIrradianceOnObjects(input);
  if (IsDark(irradiance)) return {0.0, "no light"};
  return {input.codes.LargestRise(glm::vec3(0.0f), kInvPi * object_albedo_ * irradiance),
          "all light there is on white"};
}

Bound EffectBounds::Daylight(const BoundInput& input, const VertexLight& light) {
  const glm::vec3 irradiance = light.LargestDaylight(input.basis, input.lighting);
  if (IsDark(irradiance)) return {0.0, "no daylight through windows"};
  // One reflection off an object.
  const glm::vec3 of_objects = object_albedo_ * irradiance;
  double codes = 0.0;
  if (InView(input.view)) {
    codes = input.codes.LargestRise(glm::vec3(0.0f),
                                    kInvPi * object_albedo_ * (irradiance + of_objects));
  }
  const InfluenceReach& reach = Reach(input.view);
  if (reach.largest_share > 0.0f) {
    codes = std::max(codes,
                     ChangeOfReached(input, reach, irradiance, reach.largest_share * of_objects));
  }
  return {codes, "all that windows let through to the objects"};
}

Bound EffectBounds::LightVariation(const BoundInput& input,
                                   const Bound& probe_shading,
                                   VertexLight& light) {
  if (!light.MayBeAtOnePlace()) return {kWhiteCode, "light by probes or samples"};
  if (!InView(input.view)) {
    // What they send to surfaces in view is not bounded here.
    return Reach(input.view).largest_share == 0.0f
               ? Bound{0.0, "no surface near an object in view"}
               : Bound{kWhiteCode, "objects out of view send light"};
  }
  if (probe_shading.code_values == 0.0) return probe_shading;
  // More is seen under any sky, and places need not be looked at.
  const std::optional<float> hidden = light.LargestHiddenUpTo(kMostHidden);
  if (!hidden) return {kWhiteCode, "objects hide light from themselves"};
  const OnePlaceLight& one_place = light.LightAtOnePlace(input.basis, input.lighting);
  // For what lies between the places that are compared.
  constexpr float kMargin = 1.5f;
  const float largest =
      ChangeOfFacings(input, *hidden, one_place, [](const glm::vec3& here, const glm::vec3& there) {
        return kMargin * glm::abs(there - here);
      });
  return {largest, "light at places around the objects"};
}

Bound EffectBounds::SelfOcclusion(const BoundInput& input,
                                  const Bound& probe_shading,
                                  VertexLight& light) {
  if (!InView(input.view)) {
    return Reach(input.view).largest_share == 0.0f
               ? Bound{0.0, "no surface near an object in view"}
               : Bound{kWhiteCode, "objects out of view send light"};
  }
  if (probe_shading.code_values == 0.0) return probe_shading;
  if (!IsDark(SunOf(input.lighting))) return {probe_shading.code_values, "sunlight beside them"};
  const std::optional<float> hidden =
      light.MayBeAtOnePlace() ? light.LargestHiddenUpTo(kMostHidden) : std::nullopt;
  if (!hidden) return {probe_shading.code_values, "objects hide light from themselves"};
  const OnePlaceLight& one_place = light.LightAtOnePlace(input.basis, input.lighting);
  return {ChangeOfFacings(input,
                          *hidden,
                          one_place,
                          [](const glm::vec3&, const glm::vec3&) { return glm::vec3(0.0f); }),
          "what objects hide from themselves"};
}

// Of a surface that faces any way, whose light changes so much and by what objects hide of it.
template <class ChangeOf>
float EffectBounds::ChangeOfFacings(const BoundInput& input,
                                    float hidden,
                                    const OnePlaceLight& one_place,
                                    const ChangeOf& change_of) const {
  const glm::vec3 of_hidden =
      hidden * std::numbers::pi_v<float> * one_place.LargestRadiance(input.lighting);
  const auto white = static_cast<float>(1.0 / input.codes.Exposure());
  float largest = 0.0f;
  for (const OnePlaceLight::Compared& compared : one_place.Compare(input.lighting)) {
    const glm::vec3 change = change_of(compared.here, compared.there) + of_hidden;
    const glm::vec3 least = glm::max(compared.here - change, glm::vec3(0.0f));
    // A brighter material shows more of a change, until it is white.
    const glm::vec3 to_radiance =
        glm::min(kInvPi * object_albedo_, white / glm::max(compared.here, glm::vec3(1e-30f)));
    largest = std::max(largest, input.codes.LargestRise(to_radiance * least, to_radiance * change));
  }
  return largest;
}

// A face's corners bound what lies between them: light at the vertices is interpolated.
double EffectBounds::SunOnFaces(const BoundInput& input) const {
  const Mesh& mesh = objects_.mesh;
  const glm::vec3 sun = SunOf(input.lighting);
  const glm::vec3 to_sun(input.lighting.sun.direction_enu);
  std::vector<glm::vec3> irradiance;
  for (const std::vector<glm::vec3>& of_object : input.vertex_irradiance) {
    irradiance.insert(irradiance.end(), of_object.begin(), of_object.end());
  }
  const auto white = static_cast<float>(1.0 / input.codes.Exposure());
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
    return input.codes.LargestRise(to_radiance * without, to_radiance * cosine * sun);
  };
  // Some faces, to see whether there is anything to find out.
  const std::size_t step = StepOverFew(mesh.triangles.size());
  for (std::size_t t = step / 2; t < mesh.triangles.size(); t += step) {
    if (on_face(t) > kFarAbove * input.threshold_code_values) return kWhiteCode;
  }
  return static_cast<double>(LargestOver(mesh.triangles.size(), on_face));
}

Bound EffectBounds::SunOnObjects(const BoundInput& input) {
  const glm::vec3 sun = SunOf(input.lighting);
  if (IsDark(sun)) return {0.0, "no sun"};
  if (!InView(input.view)) return {0.0, "no object in view"};
  if (any_glossy_) return {kWhiteCode, "a glint"};
  const Bound on_black{input.codes.LargestRise(glm::vec3(0.0f), kInvPi * object_diffuse_ * sun),
                       "sun on black"};
  if (on_black.code_values <= input.threshold_code_values || input.vertex_irradiance.empty()) {
    return on_black;
  }
  return {std::min(on_black.code_values, SunOnFaces(input)), "sun on the light that is there"};
}

Bound EffectBounds::SunShading(const BoundInput& input) {
  const Bound bound = SunOnObjects(input);
  if (bound.code_values == 0.0) return bound;
  if (!SunReachesObjects(input.basis)) return {0.0, "objects in the shadow of the scene"};
  return bound;
}

Bound EffectBounds::ObjectShadow(const BoundInput& input) { return SunOnObjects(input); }

Bound EffectBounds::SunShadow(const BoundInput& input) {
  if (IsDark(SunOf(input.lighting))) return {0.0, "no sun"};
  if (near_shadow_version_ != input.view.sun_version) {
    near_shadow_ = soft_sun_.PixelsNearShadow(input.view, input.basis.Sun());
    near_shadow_version_ = input.view.sun_version;
  }
  if (near_shadow_.empty()) return {0.0, "no shadow in view"};
  // Close to a surface an object hides half of what is over it, and more only where it overhangs.
  constexpr float kHiddenClose = 0.75f;
  const float share = Reach(input.view).largest_share;
  const float hidden_share = share >= InfluenceReach::kDecisive ? kHiddenClose : share;
  // Some pixels, to see whether there is anything to find out.
  const std::size_t step = StepOverFew(near_shadow_.size());
  const glm::vec3 to_sun(input.basis.Sun().direction_enu);
  for (std::size_t i = step / 2; i < near_shadow_.size(); i += step) {
    const std::size_t pixel = near_shadow_[i];
    if (!(FallInShadow(input, pixel, hidden_share) > kFarAbove * input.threshold_code_values))
      continue;
    const glm::vec3 start_m = OffsetFromSurface(input.view.position_world_m.pixels[pixel],
                                                input.view.normal_world.pixels[pixel]);
    if (objects_.caster.Occluded(start_m, to_sun)) return {kWhiteCode, "a shadow in sunlight"};
  }
  std::vector<float> falls(near_shadow_.size());
  const float largest = LargestOver(near_shadow_.size(), [&](std::size_t i) {
    falls[i] = FallInShadow(input, near_shadow_[i], hidden_share);
    return falls[i];
  });
  constexpr double kWorthRays = 0.25;
  if (!(largest > kWorthRays * input.threshold_code_values)) {
    return {largest, "little sun where a shadow may fall"};
  }
  // Shadows are narrower than the boxes around objects.
  constexpr float kUnseen = 1.0f / 64.0f;
  std::vector<std::uint32_t> lit;
  std::vector<float> lit_falls;
  for (std::size_t i = 0; i < near_shadow_.size(); ++i) {
    if (!(falls[i] > kUnseen)) continue;
    lit.push_back(near_shadow_[i]);
    lit_falls.push_back(falls[i]);
  }
  const std::vector<std::uint8_t> loses = soft_sun_.MayLoseSun(input.view, input.basis.Sun(), lit);
  float bound = kUnseen;
  for (std::size_t i = 0; i < lit.size(); ++i) {
    if (loses[i] != 0) bound = std::max(bound, lit_falls[i]);
  }
  return {bound,
          bound > kUnseen ? "a shadow in some sunlight" : "no sunlit surface in view is shaded"};
}

double EffectBounds::ChangeOfReached(const BoundInput& input,
                                     const InfluenceReach& reach,
                                     const glm::vec3& hidden,
                                     const glm::vec3& added) const {
  return static_cast<double>(LargestOver(reach.pixels.size(), [&](std::size_t i) {
    const std::size_t pixel = reach.pixels[i];
    const glm::vec3& camera = input.frame.radiance.pixels[pixel];
    if (!IsFinite(camera)) return 0.0f;
    const PixelLight light = LightOfPixel(input, pixel);
    const glm::vec3 to_radiance = kInvPi * input.view.albedo_rgb.pixels[pixel];
    const bool clipped = IsClipped(input.frame, pixel);
    const glm::vec3 without =
        clipped ? glm::max(camera, to_radiance * (light.indirect + light.direct)) : camera;
    glm::vec3 less = without;
    glm::vec3 more = without;
    for (int c = 0; c < 3; ++c) {
      // As RelitRadiance has it, or more.
      const bool is_possible = without[c] < kInvPi * light.indirect[c];
      more[c] += (is_possible ? without[c] / light.indirect[c] : kInvPi) * added[c];
      if (!(light.indirect[c] > 0.0f)) continue;
      less[c] *= std::max(1.0f - hidden[c] / light.indirect[c], 0.0f);
    }
    return std::max(input.codes.Difference(without, less), input.codes.Difference(without, more));
  }));
}

Bound EffectBounds::SkyOcclusion(const BoundInput& input) {
  const glm::vec3 largest = LargestIrradiance(input);
  if (IsDark(largest)) return {0.0, "no light"};
  const InfluenceReach& reach = Reach(input.view);
  if (reach.largest_share == 0.0f) return {0.0, "no surface near an object in view"};
  if (reach.largest_share >= InfluenceReach::kDecisive) {
    return {kWhiteCode, "an object close to a surface"};
  }
  return {ChangeOfReached(input, reach, reach.largest_share * largest, glm::vec3(0.0f)),
          "a small share of a surface's view"};
}

Bound EffectBounds::ColourBleeding(const BoundInput& input) {
  const glm::vec3 of_objects =
      object_albedo_ * (LargestIrradianceOnObjects(input) + SunOf(input.lighting));
  if (IsDark(of_objects)) return {0.0, "no light"};
  const InfluenceReach& reach = Reach(input.view);
  if (reach.largest_share == 0.0f) return {0.0, "no surface near an object in view"};
  if (reach.largest_share >= InfluenceReach::kDecisive) {
    return {kWhiteCode, "an object close to a surface"};
  }
  return {ChangeOfReached(input, reach, glm::vec3(0.0f), reach.largest_share * of_objects),
          "a small share of a surface's view"};
}

Bound EffectBounds::GlossyReflection(const BoundInput& input) {
  if (!any_glossy_) return {0.0, "nothing mirrors"};
  if (!InView(input.view)) return {0.0, "no object in view"};
  // At grazing angles all is reflected.
  const glm::vec3 radiance = kInvPi * LargestIrradianceOnObjects(input);
  if (IsDark(radiance)) return {0.0, "no light"};
  return {input.codes.LargestRise(glm::vec3(0.0f), radiance), "all light there is, mirrored"};
}

Bound EffectBounds::CameraBlur(const BoundInput& input) const {
  if (!(input.camera_blur_px > 0.0)) return {0.0, "no blur to be seen in the picture"};
  return {kWhiteCode, "edges as soft as the picture's"};
}

Bound EffectBounds::CameraNoise(const BoundInput& input) const {
  if (!input.frame.codes) return {0.0, "a linear frame"};
  return {kWhiteCode, "unknown noise"};
}

}  // namespace pleinair
