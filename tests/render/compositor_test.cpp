// The composite against ray casting and the shading formulas, pixel by pixel.
#include "render/compositor.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "composite_scene.h"
#include "ray_cast_reference.h"
#include "render/gl_context.h"
#include "scene/state_id.h"
#include "test_scenes.h"

namespace pleinair::test::compositor_test {
namespace {

// Half float keeps 11 bits, and drivers may cut off instead of rounding: 2^-10.
constexpr double kHalfRounding = 1e-3;

class CompositorTest : public testing::TestWithParam<CompositeBy> {
 protected:
  CompositorTest() { compositor_.SetPhantom(scene_.phantom); }

  Composite Render(const Mesh& object) {
    compositor_.SetObjects({{object}});
    vertex_irradiance_ = {
        std::vector<glm::vec3>(object.positions_m.size(), glm::vec3(kIrradiance))};
    return compositor_.Render(scene_.Input(vertex_irradiance_));
  }

  static constexpr float kIrradiance = 90.0f;
  HeadlessContext context_;
  Compositor compositor_{CompositorOptions{.composite_by = GetParam()}};
  CompositeScene scene_{DirectionOf(215.0, 40.0)};
  std::vector<std::vector<glm::vec3>> vertex_irradiance_;
  const Mesh sphere_ = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24);
};

// Whether one of the pixels around shows another material.
bool MeetsAnotherMaterial(const Mesh& mesh, const Image<VisiblePoint>& points, std::size_t pixel) {
  const int x = static_cast<int>(pixel) % points.width;
  const int y = static_cast<int>(pixel) / points.width;
  const auto material_at = [&](int u, int v) {
    return mesh.triangle_material[points.At(u, v).hit.triangle];
  };
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, points.height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, points.width - 1); ++u) {
      if (points.At(u, v).is_hit && material_at(u, v) != material_at(x, y)) return true;
    }
  }
  return false;
}

TEST_P(CompositorTest, ANewShadowScalesRealPixelsByTheModelsRatio) {
  const Composite composite = Render(sphere_);
  const Image<VisiblePoint> points = CastPicture(RayCaster(scene_.phantom), scene_.Camera());
  const Gray8Image shadow =
      ReferenceShadowMask(RayCaster(sphere_), points, scene_.lighting.sun.direction_enu);
  const Gray8Image edges = EdgeNeighbourhood(points, shadow, scene_.Camera());
  int scaled = 0;
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
    if (edges.pixels[i] != 0) continue;
    const bool is_shaded = shadow.pixels[i] != 0 && scene_.view.sun_visibility.pixels[i] > 0.0f;
    ASSERT_EQ(composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kScaled),
              is_shaded)
        << "pixel " << i;
    if (!is_shaded) continue;
    ++scaled;
    const glm::dvec3 expected = scene_.ModelRadiance(i, 0.0);
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(composite.radiance.pixels[i][channel] / expected[channel], 1.0, kHalfRounding);
    }
  }
  EXPECT_GT(scaled, 100);
}

TEST_P(CompositorTest, PixelsThatNothingChangesAreTheCamerasBitForBit) {
  // Values that no arithmetic leaves alone.
  scene_.radiance.pixels[0] = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  scene_.radiance.pixels[1] = glm::vec3(std::numeric_limits<float>::infinity());
  scene_.radiance.pixels[2] = glm::vec3(-1.0f, 1e-40f, 3e38f);
  const Composite composite = Render(sphere_);
  std::size_t untouched = 0;
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (composite.change.pixels[i] != 0) continue;
    ++untouched;
    EXPECT_EQ(
        std::memcmp(&composite.radiance.pixels[i], &scene_.radiance.pixels[i], sizeof(glm::vec3)),
        0);
  }
  EXPECT_GT(untouched, composite.change.pixels.size() / 2);
  EXPECT_LT(untouched, composite.change.pixels.size());
}

// Diffuse and glossy, in the sun, in its own shadow and in the wall's.
TEST_P(CompositorTest, ObjectsFollowTheShadingFormula) {
  Material glossy;
  glossy.diffuse_albedo = {0.3f, 0.2f, 0.1f};
  glossy.specular_reflectance = {0.2f, 0.3f, 0.5f};
  glossy.roughness = 0.5f;
  Material matt;
  matt.diffuse_albedo = {0.6f, 0.5f, 0.4f};
  const Mesh object = Join(Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 48, glossy),
                           Join(Sphere({-0.6f, -1.1f, 0.4f}, 0.4f, 48, matt),
                                Sphere({-0.5f, 1.6f, 0.7f}, 0.7f, 48, matt)));
  const Composite composite = Render(object);
  const Mesh everything = Join(scene_.phantom, object);
  const RayCaster caster(everything);
  const Image<VisiblePoint> points = CastPicture(caster, scene_.Camera());
  const glm::dvec3 to_sun = scene_.lighting.sun.direction_enu;
  const Gray8Image shadow = ReferenceShadowMask(caster, points, to_sun);
  const Gray8Image edges = EdgeNeighbourhood(points, shadow, scene_.Camera());
  int lit = 0;
  int dark = 0;
  for (std::size_t i = 0; i < points.pixels.size(); ++i) {
    const VisiblePoint& point = points.pixels[i];
    if (!point.is_hit || point.hit.triangle < scene_.phantom.triangles.size()) continue;
    if (edges.pixels[i] != 0) continue;
    // The facets turn away from the sun one by one, so that a pixel's samples may differ
    // there.
    const double facet = glm::dot(glm::dvec3(point.normal_to_viewer), to_sun);
    if (std::abs(facet) < 0.1) continue;
    if (MeetsAnotherMaterial(everything, points, i)) continue;
    ASSERT_EQ(composite.change.pixels[i], static_cast<std::uint8_t>(PixelChange::kCovered));
    const double sun = facet > 0.0 && shadow.pixels[i] == 0 ? 1.0 : 0.0;
    const glm::dvec3 expected =
        ShadedObject(everything, point, scene_.Camera(), {scene_.lighting, kIrradiance, sun});
    for (int channel = 0; channel < 3; ++channel) {
      // Half float, and the samples' mean against the pixel's centre: second order in the pixel's
      // size, at a radius of 24 px and a lobe of alpha 0.25, which is as much wider as the normal
      // turns over a sample.
      EXPECT_NEAR(composite.radiance.pixels[i][channel] / expected[channel], 1.0, 1.5e-2)
          << "pixel " << i << " sun " << sun;
    }
    (sun > 0.0 ? lit : dark) += 1;
  }
  EXPECT_GT(lit, 300);
  EXPECT_GT(dark, 300);
}

// Darker, brighter in one channel alone, and beyond black; in the shadow of the object and beside.
TEST_P(CompositorTest, AChangeOfIrradianceScalesRealPixels) {
  const glm::vec3 changes[] = {{-30.0f, -20.0f, -10.0f}, {0.0f, 40.0f, 0.0f}, glm::vec3(-1e6f)};
  IrradianceChange change{20, 10, RgbImage(150, 120, glm::vec3(0.0f))};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 150; ++x) change.irradiance_rgb.At(x, y) = changes[(x / 10) % 3];
  }
  compositor_.SetObjects({{sphere_}});
  vertex_irradiance_ = {std::vector<glm::vec3>(sphere_.positions_m.size(), glm::vec3(kIrradiance))};
  const Composite without = compositor_.Render(scene_.Input(vertex_irradiance_));
  CompositeInput input = scene_.Input(vertex_irradiance_);
  input.irradiance_change = &change;
  const Composite with = compositor_.Render(input);
  int lit = 0;
  int shaded = 0;
  for (int y = 0; y < scene_.view.Height(); ++y) {
    for (int x = 0; x < scene_.view.Width(); ++x) {
      const std::size_t i = scene_.view.region.Index(x, y);
      const bool is_inside = x >= 20 && x < 170 && y >= 10 && y < 130;
      if (!is_inside || scene_.view.region.pixels[i] == SurfaceView::kNoRegion) {
        ASSERT_EQ(with.radiance.pixels[i], without.radiance.pixels[i]);
        ASSERT_EQ(with.change.pixels[i], without.change.pixels[i]);
        continue;
      }
      // Its edge and the shadow's blend.
      if (without.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
      const bool is_lit = without.radiance.pixels[i] == scene_.radiance.pixels[i];
      const glm::dvec3 shade = scene_.ModelRadiance(i, 0.0);
      const glm::dvec3 before(without.radiance.pixels[i]);
      if (!is_lit && std::abs(before.x / shade.x - 1.0) > kHalfRounding) continue;
      ASSERT_EQ(with.change.pixels[i], static_cast<std::uint8_t>(PixelChange::kScaled));
      const glm::dvec3 to_radiance =
          glm::dvec3(scene_.view.albedo_rgb.pixels[i]) / std::numbers::pi;
      const glm::dvec3 change_of_radiance =
          to_radiance * glm::dvec3(change.irradiance_rgb.At(x - 20, y - 10));
      for (int c = 0; c < 3; ++c) {
        const double direct = before[c] - shade[c];
        const double expected =
            std::max(shade[c] + change_of_radiance[c], 0.0) + (is_lit ? direct : 0.0);
        EXPECT_NEAR(with.radiance.pixels[i][c], expected, kHalfRounding * before[c]);
      }
      (is_lit ? lit : shaded) += 1;
    }
  }
  EXPECT_GT(lit, 1000);
  EXPECT_GT(shaded, 100);
}

TEST_P(CompositorTest, AChangeThatRoundingWouldLoseIsNone) {
  compositor_.SetObjects({{sphere_}});
  vertex_irradiance_ = {std::vector<glm::vec3>(sphere_.positions_m.size(), glm::vec3(kIrradiance))};
  const Composite without = compositor_.Render(scene_.Input(vertex_irradiance_));
  // Less than 2^-11 of what any surface here gets, its share of the sky alone being 80.
  const IrradianceChange change{
      0, 0, RgbImage(scene_.view.Width(), scene_.view.Height(), glm::vec3(0.03f))};
  CompositeInput input = scene_.Input(vertex_irradiance_);
  input.irradiance_change = &change;
  const Composite with = compositor_.Render(input);
  EXPECT_EQ(with.change.pixels, without.change.pixels);
}

TEST_P(CompositorTest, RefusesAChangeBeyondThePicture) {
  compositor_.SetObjects({});
  CompositeInput input = scene_.Input({});
  const IrradianceChange change{200, 0, RgbImage(41, 10)};
  input.irradiance_change = &change;
  EXPECT_THROW(compositor_.Render(input), std::invalid_argument);
}

TEST_P(CompositorTest, AnObjectsEdgeBlendsWithTheCamera) {
  // Before a black picture, coverage can be read off.
  scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  scene_.radiance = RgbImage(scene_.view.Width(), scene_.view.Height());
  const Composite composite = Render(sphere_);
  const float object_level = kIrradiance * 0.5f / std::numbers::pi_v<float>;
  int partly = 0;
  for (const glm::vec3& pixel : composite.radiance.pixels) {
    EXPECT_LE(pixel.r, 1.001f * object_level);
    partly += pixel.r > 0.2f * object_level && pixel.r < 0.8f * object_level ? 1 : 0;
  }
  EXPECT_GT(partly, 20);
}

TEST_P(CompositorTest, NothingButTheObjectChangesWhenThereIsNoSun) {
  scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  scene_.RenderCameraFromModel();
  const Composite composite = Render(sphere_);
  int covered = 0;
  for (const std::uint8_t change : composite.change.pixels) {
    EXPECT_NE(change, static_cast<std::uint8_t>(PixelChange::kScaled));
    covered += change != 0 ? 1 : 0;
  }
  EXPECT_GT(covered, 300);
}

TEST_P(CompositorTest, APixelThatLooksShadedHasNoSunToLose) {
  // A tree that the mesh lacks: all of the ground is darker than the mesh says.
  for (std::size_t i = 0; i < scene_.radiance.pixels.size(); ++i) {
    scene_.radiance.pixels[i] = glm::vec3(scene_.ModelRadiance(i, 0.0));
  }
  const Composite composite = Render(sphere_);
  for (const std::uint8_t change : composite.change.pixels) {
    EXPECT_NE(change, static_cast<std::uint8_t>(PixelChange::kScaled));
  }
}

TEST_P(CompositorTest, APixelThatLooksLitLosesTheSunWhereTheMeshMisplacesAShadow) {
  const Composite before = Render(sphere_);
  // The mesh says shade right up to here, the camera says sun.
  for (std::size_t i = 0; i < scene_.view.sun_visibility.pixels.size(); ++i) {
    scene_.view.sun_visibility.pixels[i] = 0.0f;
    scene_.view.edge_distance_px.pixels[i] = 1.0f;
  }
  scene_.view.sun_id = StateId::Next();
  const Composite after = Render(sphere_);
  EXPECT_EQ(before.change.pixels, after.change.pixels);
}

TEST_P(CompositorTest, ADeadChannelDoesNotDecideWhetherThereIsSun) {
  const Composite before = Render(sphere_);
  for (glm::vec3& radiance : scene_.radiance.pixels) radiance.b = 0.0f;
  const Composite after = Render(sphere_);
  EXPECT_EQ(before.change.pixels, after.change.pixels);
}

TEST_P(CompositorTest, AClippedPixelTakesTheModelsRadianceInANewShadowOnly) {
  RgbImage clipped_picture = scene_.radiance;
  for (std::size_t i = 0; i < clipped_picture.pixels.size(); ++i) {
    scene_.clipped.pixels[i] = 1;
    scene_.radiance.pixels[i] = 0.5f * clipped_picture.pixels[i];  // A bound below the truth.
  }
  const Composite composite = Render(sphere_);
  int scaled = 0;
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kScaled)) continue;
    // Full change in the shadow; between both on its edge, where a pixel is partly in it.
    const double shaded = scene_.ModelRadiance(i, 0.0).g;
    const double lit = scene_.ModelRadiance(i, 1.0).g;
    const double found = composite.radiance.pixels[i].g;
    EXPECT_GE(found, (1.0 - kHalfRounding) * shaded);
    EXPECT_LE(found, (1.0 + kHalfRounding) * lit);
    if (std::abs(found / shaded - 1.0) <= kHalfRounding) ++scaled;
  }
  EXPECT_GT(scaled, 100);
}

TEST_P(CompositorTest, EffectsCanBeSwitchedOff) {
  compositor_.SetObjects({{sphere_}});
  vertex_irradiance_ = {std::vector<glm::vec3>(sphere_.positions_m.size(), glm::vec3(kIrradiance))};
  CompositeInput input = scene_.Input(vertex_irradiance_);
  const auto mean_of_object = [&](const Composite& composite) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
      if (composite.change.pixels[i] != 255) continue;
      sum += composite.radiance.pixels[i].g;
      ++count;
    }
    return sum / count;
  };
  const double all = mean_of_object(compositor_.Render(input));
  input.effects.sun_shadow = false;
  input.effects.object_shadow = false;
  const Composite unshadowed = compositor_.Render(input);
  for (const std::uint8_t change : unshadowed.change.pixels) EXPECT_NE(change, 128);
  EXPECT_GE(mean_of_object(unshadowed), all);
  input.effects.sun_shading = false;
  const double probes = mean_of_object(compositor_.Render(input));
  EXPECT_LT(probes, 0.9 * all);
  input.effects.probe_shading = false;
  EXPECT_LT(mean_of_object(compositor_.Render(input)), 0.3 * probes);  // What shines at its edges.
}

TEST_P(CompositorTest, RadiancesInAnyUnitGiveTheSamePicture) {
  const Composite unit = Render(sphere_);
  // The composite's own clamp is at 65504, so that the largest scale stays below.
  for (const int exponent : {-40, -13, 5}) {
    CompositeScene scaled(DirectionOf(215.0, 40.0));
    const double scale = std::ldexp(1.0, exponent);
    scaled.lighting.sun.irradiance_rgb *= scale;
    scaled.lighting.sky[0].irradiance_rgb *= scale;
    scaled.RenderCameraFromModel();
    vertex_irradiance_ = {std::vector<glm::vec3>(
        sphere_.positions_m.size(), glm::vec3(static_cast<float>(scale) * kIrradiance))};
    const Composite composite = compositor_.Render(scaled.Input(vertex_irradiance_));
    EXPECT_EQ(composite.change.pixels, unit.change.pixels) << exponent;
    for (std::size_t i = 0; i < unit.radiance.pixels.size(); ++i) {
      // A power of two changes no digit, but for the camera's own rounding to float.
      EXPECT_NEAR(composite.radiance.pixels[i].g,
                  scale * unit.radiance.pixels[i].g,
                  2e-3 * scale * (1e-3 + unit.radiance.pixels[i].g))
          << exponent;
    }
  }
}

// Two sky shapes that add up to one light make the same picture as one.
TEST_P(CompositorTest, SkyShapesAddUp) {
  const Composite one = Render(sphere_);
  scene_.view.sky_response.push_back(scene_.view.sky_response[0]);
  scene_.lighting.sky.push_back(scene_.lighting.sky[0]);
  scene_.lighting.sky[0].irradiance_rgb *= 0.25;
  scene_.lighting.sky[1].irradiance_rgb *= 0.75;
  scene_.view.sky_id = StateId::Next();
  const Composite two = Render(sphere_);
  EXPECT_EQ(one.change.pixels, two.change.pixels);
  for (std::size_t i = 0; i < one.radiance.pixels.size(); ++i) {
    EXPECT_NEAR(one.radiance.pixels[i].g, two.radiance.pixels[i].g, 0.1f);
  }
}

// Layers are drawn without distortion and looked up; where the object shows has to agree with rays
// through the distorted pixels.
TEST_P(CompositorTest, LensDistortionBendsTheLayersAndLeavesTheCameraAlone) {
  CameraIntrinsics lens = scene_.Camera().intrinsics;
  lens.distortion = {-0.25, 0.06, 0.001, -0.0005, 0.0};
  scene_.SetIntrinsics(lens);
  const Composite composite = Render(sphere_);
  const RayCaster phantom(scene_.phantom);
  const RayCaster object(sphere_);
  const glm::dmat3 world_from_camera =
      glm::transpose(glm::dmat3(scene_.Camera().camera_from_world));
  const glm::vec3 eye(scene_.Camera().CentreWorldM());
  Gray8Image shows(lens.width_px, lens.height_px, 0);
  for (int y = 0; y < lens.height_px; ++y) {
    for (int x = 0; x < lens.width_px; ++x) {
      const glm::vec3 direction(world_from_camera * *DirectionFromPixel(lens, {x, y}));
      const auto hit = object.Intersect(eye, direction);
      const auto before = phantom.Intersect(eye, direction);
      const bool is_covered = hit && !(before && before->distance_m < hit->distance_m);
      shows.At(x, y) = is_covered ? 255 : 0;
      if (is_covered || !before) continue;
      const glm::vec3 to_sun(scene_.lighting.sun.direction_enu);
      const bool in_shadow = scene_.view.sun_visibility.At(x, y) > 0.0f &&
                             glm::dot(before->geometric_normal, to_sun) > 0.0f &&
                             object.Occluded(before->position_m, to_sun);
      shows.At(x, y) = in_shadow ? 128 : 0;
    }
  }
  int wrong = 0;
  int scaled = 0;
  int covered = 0;
  for (int y = 2; y + 2 < lens.height_px; ++y) {
    for (int x = 2; x + 2 < lens.width_px; ++x) {
      bool is_edge = false;
      for (int v = y - 2; v <= y + 2; ++v) {
        for (int u = x - 2; u <= x + 2; ++u) is_edge |= shows.At(u, v) != shows.At(x, y);
      }
      if (is_edge) continue;
      wrong += composite.change.At(x, y) != shows.At(x, y) ? 1 : 0;
      scaled += shows.At(x, y) == 128 ? 1 : 0;
      covered += shows.At(x, y) == 255 ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(scaled, 50);
  EXPECT_GT(covered, 300);
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (composite.change.pixels[i] == 0) {
      ASSERT_EQ(composite.radiance.pixels[i], scene_.radiance.pixels[i]);
    }
  }
}

TEST_P(CompositorTest, DesktopAndEmbeddedOpenGlShowTheSame) {
  const Composite desktop = Render(sphere_);
  const HeadlessContext es_context(GlApi::kEs31);
  Compositor es_compositor(CompositorOptions{.composite_by = GetParam()});
  es_compositor.SetPhantom(scene_.phantom);
  es_compositor.SetObjects({{sphere_}});
  const Composite es = es_compositor.Render(scene_.Input(vertex_irradiance_));
  std::size_t different = 0;
  for (std::size_t i = 0; i < desktop.change.pixels.size(); ++i) {
    different += desktop.change.pixels[i] != es.change.pixels[i] ? 1 : 0;
  }
  EXPECT_LE(different, desktop.change.pixels.size() / 1000);
}

TEST_P(CompositorTest, NamesWhatDoesNotFit) {
  compositor_.SetObjects({{sphere_}});
  vertex_irradiance_ = {std::vector<glm::vec3>(sphere_.positions_m.size(), glm::vec3(kIrradiance))};
  const auto message_of = [&](const std::function<void()>& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  const RgbImage small(3, 2);
  const CompositeInput wrong_picture{
      small, scene_.clipped, scene_.view, scene_.lighting, vertex_irradiance_, {}};
  EXPECT_EQ(message_of([&] { compositor_.Render(wrong_picture); }),
            "camera_radiance is 3x2, expected 240x180, the size of view.region");
  vertex_irradiance_[0].pop_back();
  EXPECT_NE(message_of([&] {
              compositor_.Render(scene_.Input(vertex_irradiance_));
            }).find("vertex_irradiance[0] has"),
            std::string::npos);
  vertex_irradiance_[0].push_back(glm::vec3(0.0f));
  scene_.lighting.sky.clear();
  EXPECT_NE(message_of([&] {
              compositor_.Render(scene_.Input(vertex_irradiance_));
            }).find("lighting.sky has 0 shapes"),
            std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(ByBoth, CompositorTest, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::compositor_test
