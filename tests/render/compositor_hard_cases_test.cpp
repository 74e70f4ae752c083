#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "scene/half_float.h"
#include "scene/state_id.h"
#include "test_scenes.h"

namespace pleinair::test::compositor_hard_cases_test {
namespace {

class CompositorHardCase : public testing::TestWithParam<CompositeBy> {
 protected:
  Composite Render(const CompositeScene& scene, const Mesh& object) {
    compositor_.SetPhantom(scene.phantom);
    compositor_.SetObjects({{object}});
    const std::vector<std::vector<glm::vec3>> irradiance{
        std::vector<glm::vec3>(object.positions_m.size(), glm::vec3(90.0f))};
    return compositor_.Render(scene.Input(irradiance));
  }

  static void ExpectSound(const CompositeScene& scene,
                          const Composite& composite,
                          const std::string& what) {
    for (std::size_t i = 0; i < composite.radiance.pixels.size(); ++i) {
      const glm::vec3& pixel = composite.radiance.pixels[i];
      if (composite.change.pixels[i] == 0) {
        ASSERT_EQ(pixel, scene.radiance.pixels[i]) << what << ", pixel " << i;
        continue;
      }
      for (int channel = 0; channel < 3; ++channel) {
        ASSERT_TRUE(pixel[channel] >= 0.0f && std::isfinite(pixel[channel]))
            << what << ", pixel " << i << ": " << pixel[channel];
      }
    }
  }

  static std::size_t CountChanged(const Composite& composite) {
    std::size_t count = 0;
    for (const std::uint8_t change : composite.change.pixels) count += change != 0 ? 1 : 0;
    return count;
  }

  HeadlessContext context_;
  Compositor compositor_{CompositorOptions{.composite_by = GetParam()}};
  const glm::dvec3 to_sun_ = DirectionOf(215.0, 40.0);
};

TEST_P(CompositorHardCase, TwoRunsAreBitIdentical) {
  const CompositeScene scene(to_sun_);
  const Mesh sphere = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24);
  const Composite first = Render(scene, sphere);
  const Composite again = Render(scene, sphere);
  Compositor other(CompositorOptions{.composite_by = GetParam()});
  other.SetPhantom(scene.phantom);
  other.SetObjects({{sphere}});
  const std::vector<std::vector<glm::vec3>> irradiance{
      std::vector<glm::vec3>(sphere.positions_m.size(), glm::vec3(90.0f))};
  const Composite elsewhere = other.Render(scene.Input(irradiance));
  EXPECT_EQ(first.radiance.pixels, again.radiance.pixels);
  EXPECT_EQ(first.radiance.pixels, elsewhere.radiance.pixels);
  EXPECT_EQ(first.change.pixels, elsewhere.change.pixels);
}

// What was kept of an earlier frame shows nowhere.
TEST_P(CompositorHardCase, FramesDoNotRememberOtherFrames) {
  const CompositeScene scene(to_sun_);
  const CompositeScene other_sun(DirectionOf(120.0, 30.0));
  const CompositeScene smaller(to_sun_, 100, 70);
  const Mesh sphere = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24);
  const Composite fresh = Render(scene, sphere);
  Render(other_sun, Box({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 2.5f}));
  Render(smaller, Sphere({0.5f, 0.0f, 1.0f}, 0.5f, 8));
  Render(scene, Sphere({0.5f, 0.5f, 1.5f}, 0.5f, 8));
  Render(scene, sphere);
  const std::vector<std::vector<glm::vec3>> irradiance{
      std::vector<glm::vec3>(sphere.positions_m.size(), glm::vec3(90.0f))};
  const Composite after = compositor_.Render(scene.Input(irradiance));
  EXPECT_EQ(fresh.radiance.pixels, after.radiance.pixels);
  EXPECT_EQ(fresh.change.pixels, after.change.pixels);
}

TEST_P(CompositorHardCase, PicturesOfEverySize) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(641, 479), std::pair(2, 301), std::pair(301, 2)}) {
    const CompositeScene scene(to_sun_, width, height);
    const Composite composite = Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24));
    ExpectSound(scene, composite, std::to_string(width) + "x" + std::to_string(height));
    if (width > 2 && height > 2) {
      EXPECT_GT(CountChanged(composite), 1000u);
    }
  }
}

// The widest supported picture; only a strip of it, to limit the test's memory.
TEST_P(CompositorHardCase, AStripOf4096Pixels) {
  const CompositeScene scene(to_sun_, 4096, 216);
  const Composite composite = Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24));
  ExpectSound(scene, composite, "4096x216");
  EXPECT_GT(CountChanged(composite), 1000u);
  // And an object along all of it.
  const Composite all_along = Render(scene, Box({-40.0f, -0.1f, 0.8f}, {40.0f, 0.1f, 0.9f}));
  ExpectSound(scene, all_along, "4096x216, all along");
  EXPECT_GT(CountChanged(all_along), 4096u);
}

TEST_P(CompositorHardCase, AbsentObjectsChangeNothing) {
  const CompositeScene scene(to_sun_);
  EXPECT_EQ(CountChanged(Render(scene, Mesh{})), 0u);
  EXPECT_EQ(CountChanged(Render(scene, Sphere({9.0f, -10.0f, 1.0f}, 0.5f, 8))), 0u);
  EXPECT_EQ(CountChanged(Render(scene, Sphere({0.0f, 0.0f, -3.0f}, 0.5f, 8))), 0u);
  compositor_.SetObjects({});
  EXPECT_EQ(CountChanged(compositor_.Render(scene.Input({}))), 0u);
}

TEST_P(CompositorHardCase, ObjectsOfAnySizeAndPlace) {
  const CompositeScene scene(to_sun_);
  const glm::vec3 eye(scene.Camera().CentreWorldM());
  const struct {
    Mesh mesh;
    const char* what;
  } cases[] = {{Sphere({0.0f, 0.0f, 0.0005f}, 0.0005f, 8), "1 mm"},
               {Sphere({0.0f, 1500.0f, 0.0f}, 500.0f, 24), "1 km, far"},
               {Sphere(eye, 500.0f, 24), "1 km, around the camera"},
               {Sphere(eye, 0.2f, 12), "around the camera"},
               {Box({-1.0f, -1.0f, -1.0f}, {1.0f, 1.0f, 1.0f}), "half in the ground"},
               {Ground(2.0f), "a carpet in the ground's own plane"},
               {Box({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}), "flat box"}};
  for (const auto& [mesh, what] : cases) {
    ExpectSound(scene, Render(scene, mesh), what);
  }
}

TEST_P(CompositorHardCase, NoPhantomAtAll) {
  CompositeScene scene(to_sun_);
  scene.phantom = Mesh{};
  const Composite composite = Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24));
  ExpectSound(scene, composite, "no phantom");
  EXPECT_GT(CountChanged(composite), 300u);
}

// A mirror under a sun that no half float holds: what is written is clamped and counted.
TEST_P(CompositorHardCase, SunGlintOnAMirrorIsFiniteAndCanBeWritten) {
  CompositeScene scene(to_sun_);
  scene.lighting.sun.irradiance_rgb = glm::dvec3(1e5);
  scene.RenderCameraFromModel();
  Material chrome;
  chrome.diffuse_albedo = glm::vec3(0.0f);
  chrome.specular_reflectance = glm::vec3(0.85f);
  chrome.roughness = 0.0f;
  Composite composite = Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 64, chrome));
  ExpectSound(scene, composite, "chrome");
  std::int64_t beyond = 0;
  for (const glm::vec3& pixel : composite.radiance.pixels) {
    beyond += std::max({pixel.r, pixel.g, pixel.b}) > kLargestHalf ? 1 : 0;
  }
  EXPECT_GT(beyond, 0);
  EXPECT_EQ(ClampToHalf(composite.radiance), beyond);
  EXPECT_EQ(ClampToHalf(composite.radiance), 0);
}

TEST_P(CompositorHardCase, DeadAndBrokenCameraPixelsStayOut) {
  CompositeScene scene(to_sun_);
  for (std::size_t i = 0; i < scene.radiance.pixels.size(); ++i) {
    if (i % 3 == 0) scene.radiance.pixels[i] = glm::vec3(std::nanf(""));
    if (i % 3 == 1) scene.radiance.pixels[i] = glm::vec3(HUGE_VALF);
  }
  const Composite composite = Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24));
  for (std::size_t i = 0; i < composite.radiance.pixels.size(); ++i) {
    if (composite.change.pixels[i] != 0) {
      EXPECT_TRUE(std::isfinite(composite.radiance.pixels[i].g)) << "pixel " << i;
    }
  }
  EXPECT_GT(CountChanged(composite), 300u);
}

TEST_P(CompositorHardCase, AModelWithoutLightOrAlbedoTouchesNothing) {
  CompositeScene scene(to_sun_);
  for (glm::vec3& response : scene.view.sky_response[0].pixels) response = glm::vec3(0.0f);
  for (glm::vec3& bounce : scene.view.sun_bounce.pixels) bounce = glm::vec3(0.0f);
  scene.view.sky_id = StateId::Next();
  scene.view.sun_id = StateId::Next();
  // Lit, and black once the sun is taken away: 0 / x is right, x / 0 does not occur.
  ExpectSound(scene, Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24)), "no sky");
  for (glm::vec3& albedo : scene.view.albedo_rgb.pixels) albedo = glm::vec3(0.0f);
  scene.view.geometry_id = StateId::Next();
  ExpectSound(scene, Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24)), "no albedo");
  scene.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  scene.lighting.sky[0].irradiance_rgb = glm::dvec3(0.0);
  ExpectSound(scene, Render(scene, Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24)), "night");
}

INSTANTIATE_TEST_SUITE_P(ByBoth, CompositorHardCase, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::compositor_hard_cases_test
