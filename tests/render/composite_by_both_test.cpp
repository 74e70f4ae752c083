// The composite by the processor against that by the device, on what each does in its own way:
// parts of pictures, lenses, shadows by volumes and by shares, light at vertices, what is kept.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <epoxy/gl.h>
#include <gtest/gtest.h>
#include <glm/trigonometric.hpp>

#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "render/software_driver.h"
#include "scene/state_id.h"
#include "test_scenes.h"
#include "textured_meshes.h"

namespace pleinair::test::composite_by_both_test {
namespace {

Material Shiny() {
  Material material;
  material.diffuse_albedo = {0.3f, 0.2f, 0.1f};
  material.specular_reflectance = {0.2f, 0.3f, 0.5f};
  material.roughness = 0.5f;
  return material;
}

class CompositeByBoth : public testing::Test {
 protected:
  Composite Render(CompositeBy by) {
    Compositor compositor(CompositorOptions{.composite_by = by});
    return RenderBy(compositor);
  }

  Composite RenderBy(Compositor& compositor) {
    compositor.SetPhantom(scene_.phantom);
    compositor.SetObjects(objects_);
    return Again(compositor);
  }

  // No two vertices have the same light.
  Composite Again(Compositor& compositor) {
    vertex_irradiance_.clear();
    for (const VirtualObject& object : objects_) {
      std::vector<glm::vec3> of_object;
      for (const glm::vec3& p : object.mesh.positions_m) {
        of_object.push_back(light_ * (glm::vec3(90.0f) + 30.0f * glm::sin(7.0f * p)));
      }
      vertex_irradiance_.push_back(of_object);
    }
    CompositeInput input = scene_.Input(vertex_irradiance_);
    adapt_(input);
    return compositor.Render(input);
  }

  // Returns how many pixels change.
  std::size_t ExpectTheSame(const std::string& what) {
    return ExpectTheSame(Render(CompositeBy::kDevice), Render(CompositeBy::kProcessor), what);
  }

  std::size_t ExpectTheSame(const Composite& device,
                            const Composite& processor,
                            const std::string& what) const {
    const std::size_t count = device.change.pixels.size();
    std::size_t otherwise = 0;
    std::size_t changed = 0;
    std::size_t differing = 0;
    for (std::size_t i = 0; i < count; ++i) {
      changed += processor.change.pixels[i] != 0 ? 1 : 0;
      if (device.change.pixels[i] != processor.change.pixels[i]) {
        ++otherwise;
        continue;
      }
      const glm::vec3& a = device.radiance.pixels[i];
      const glm::vec3& b = processor.radiance.pixels[i];
      if (device.change.pixels[i] == 0) {
        EXPECT_EQ(a, b);
        continue;
      }
      bool differs = false;
      for (int c = 0; c < 3; ++c) {
        // Half floats that may be cut off instead of rounded, 2^-10 each: a sample's light from the
        // vertices, that with the sun, the samples' mean, the composite. So may the coverage be,
        // which the real pixel shows through.
        const float through = std::ldexp(std::max(scene_.radiance.pixels[i][c], 0.0f), -11);
        const float bound = (4e-3f + of_places_) * std::max(a[c], 0.01f) + through;
        EXPECT_NEAR(a[c], b[c], of_bound_ * bound) << what << ", pixel " << i;
        differs = differs || !(std::abs(a[c] - b[c]) <= bound);
      }
      if (differs) ++differing;
    }
    // At turning points: a change that is just none, coverage that half a float loses.
    EXPECT_LE(otherwise, 1 + count / 1000) << what;
    EXPECT_LE(differing, 1 + count / 10000) << what;
    return changed;
  }

  void BendTheLens() {
    CameraIntrinsics lens = scene_.Camera().intrinsics;
    lens.distortion = {-0.25, 0.06, 0.001, -0.0005, 0.0};
    scene_.SetIntrinsics(lens);
  }

  HeadlessContext context_;
  // A GPU's edges and decisions differ in single pixels.
  const float of_bound_ = DrawsOnProcessor(context_.Describe().renderer.c_str()) ? 1.0f : 10.0f;
  CompositeScene scene_{DirectionOf(215.0, 40.0), 160, 120};
  std::vector<VirtualObject> objects_{{Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24)}};
  glm::vec3 light_{1.0f, 0.9f, 0.7f};
  std::function<void(CompositeInput&)> adapt_ = [](CompositeInput&) {};
  std::vector<std::vector<glm::vec3>> vertex_irradiance_;
  // What a device's own way of finding a sample's place in a texture may bring.
  float of_places_ = 0.0f;
};

TEST_F(CompositeByBoth, IsTheSameWhereverObjectsStandInThePicture) {
  const glm::vec3 eye(scene_.Camera().CentreWorldM());
  const struct {
    std::vector<VirtualObject> objects;
    const char* what;
  } cases[] = {
      {{{Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24)}}, "in the middle"},
      {{{Sphere({-2.6f, 0.0f, 1.0f}, 0.8f, 24)}}, "to the left"},
      {{{Sphere({2.6f, 0.0f, 2.2f}, 0.9f, 24)}}, "to the right and above"},
      {{{Sphere({0.0f, -3.2f, 0.3f}, 0.7f, 24)}}, "below"},
      {{{Sphere({-2.4f, 0.5f, 0.6f}, 0.6f, 16, Shiny())}, {Sphere({2.4f, -0.5f, 0.5f}, 0.4f, 16)}},
       "two far apart"},
      {{{Sphere(eye, 0.5f, 12)}}, "around the camera"},
      {{{Box({-1.0f, -1.0f, -1.0f}, {1.0f, 1.0f, 1.0f}, Shiny())}}, "half in the ground"},
      {{{Sphere({9.0f, -10.0f, 1.0f}, 0.5f, 8)}}, "out of sight"}};
  for (const bool is_bent : {false, true}) {
    if (is_bent) BendTheLens();
    std::size_t changed = 0;
    for (const auto& [objects, what] : cases) {
      objects_ = objects;
      changed += ExpectTheSame(std::string(what) + (is_bent ? ", by a bent lens" : ""));
    }
    EXPECT_GT(changed, 5000u);
  }
}

// The layer of what is no longer there is not looked at.
TEST_F(CompositeByBoth, IsTheSameOfObjectsThatHaveLeftTheirEffectBehind) {
  IrradianceChange change{0, 0, RgbImage(160, 120)};
  for (glm::vec3& rgb : change.irradiance_rgb.pixels) rgb = glm::vec3(-9.0f, -8.0f, -7.0f);
  adapt_ = [&](CompositeInput& input) { input.irradiance_change = &change; };
  Compositor by_device(CompositorOptions{.composite_by = CompositeBy::kDevice});
  Compositor by_processor(CompositorOptions{.composite_by = CompositeBy::kProcessor});
  RenderBy(by_device);
  RenderBy(by_processor);
  objects_ = {{Sphere({9.0f, -10.0f, 1.0f}, 0.5f, 8)}};
  const Composite device = RenderBy(by_device);
  const Composite processor = RenderBy(by_processor);
  EXPECT_GT(ExpectTheSame(device, processor, "left"), 5000u);
  for (const std::uint8_t what : device.change.pixels) {
    EXPECT_NE(what, static_cast<std::uint8_t>(PixelChange::kCovered));
  }
}

// Of a view that stands, only the part that a frame needs is on the device.
TEST_F(CompositeByBoth, IsTheSameWhereObjectsMoveOverAViewThatStands) {
  Compositor by_device(CompositorOptions{.composite_by = CompositeBy::kDevice});
  for (const float x_m : {-2.6f, 2.6f, 0.0f, -2.6f}) {
    objects_ = {{Sphere({x_m, 0.0f, 1.0f}, 0.6f, 16)}};
    const Composite device = RenderBy(by_device);
    const std::size_t changed =
        ExpectTheSame(device, Render(CompositeBy::kProcessor), "at " + std::to_string(x_m) + " m");
    EXPECT_GT(changed, 300u);
  }
}

// The device's part of a view follows the view's state, also where it was larger before.
TEST_F(CompositeByBoth, IsTheSameWhereAViewChangesUnderTheDevicesPart) {
  Compositor by_device(CompositorOptions{.composite_by = CompositeBy::kDevice});
  RgbImage& sky = scene_.view.sky_response.front();
  for (const auto& [x_m, brighter] :
       {std::pair{0.0f, 1.0f}, std::pair{-2.6f, 0.5f}, std::pair{0.0f, 1.0f}}) {
    for (glm::vec3& response : sky.pixels) response *= brighter;
    if (brighter != 1.0f) scene_.view.sky_id = StateId::Next();
    objects_ = {{Sphere({x_m, 0.0f, 1.0f}, 0.6f, 16)}};
    ExpectTheSame(
        RenderBy(by_device), Render(CompositeBy::kProcessor), "at " + std::to_string(x_m));
  }
}

TEST_F(CompositeByBoth, TimesTheDeviceByItsClock) {
  const Composite device = Render(CompositeBy::kDevice);
  EXPECT_GT(device.device_ms, 0.0);
  EXPECT_LE(device.device_ms, device.draw_ms);
  EXPECT_EQ(Render(CompositeBy::kProcessor).device_ms, 0.0);
}

// An application may stream its own pictures through the same context.
TEST_F(CompositeByBoth, IsTheSameWhateverTheApplicationsPixelLayout) {
  BendTheLens();
  const Composite before = Render(CompositeBy::kDevice);
  GLuint buffers[2] = {0, 0};
  glGenBuffers(2, buffers);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers[0]);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffers[1]);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 7);
  glPixelStorei(GL_UNPACK_SKIP_ROWS, 2);
  glPixelStorei(GL_PACK_ROW_LENGTH, 7);
  for (const CompositeBy by : kByBoth) {
    const Composite now = Render(by);
    ExpectTheSame(now, Render(CompositeBy::kProcessor), "with a layout");
    EXPECT_EQ(now.change.pixels, before.change.pixels);
  }
  const auto value_of = [](GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
  };
  EXPECT_EQ(value_of(GL_PIXEL_UNPACK_BUFFER_BINDING), static_cast<GLint>(buffers[0]));
  EXPECT_EQ(value_of(GL_PIXEL_PACK_BUFFER_BINDING), static_cast<GLint>(buffers[1]));
  EXPECT_EQ(value_of(GL_UNPACK_ROW_LENGTH), 7);
  EXPECT_EQ(value_of(GL_UNPACK_SKIP_ROWS), 2);
  EXPECT_EQ(value_of(GL_PACK_ROW_LENGTH), 7);
}

TEST_F(CompositeByBoth, IsTheSameWithAllThatRayCastingSays) {
  objects_ = {{Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24, Shiny())}};
  IrradianceChange change{100, 60, RgbImage(60, 60)};  // To the picture's very corner.
  SunShares shares{{0, 30, GrayImage(50, 90)}, {0, 0, GrayImage(2 * 160, 2 * 120)}};
  MirroredLight mirrored{70, 40, RgbImage(30, 20)};
  for (std::size_t i = 0; i < change.irradiance_rgb.pixels.size(); ++i) {
    change.irradiance_rgb.pixels[i] = glm::vec3(static_cast<float>(i % 7) - 5.0f, 3.0f, -2.0f);
  }
  for (std::size_t i = 0; i < shares.real.hidden.pixels.size(); ++i) {
    shares.real.hidden.pixels[i] = static_cast<float>(i % 5) / 4.0f;
  }
  for (std::size_t i = 0; i < shares.objects.seen.pixels.size(); ++i) {
    shares.objects.seen.pixels[i] = static_cast<float>(i % 3) / 2.0f;
  }
  for (std::size_t i = 0; i < mirrored.radiance.pixels.size(); ++i) {
    mirrored.radiance.pixels[i] = glm::vec3(static_cast<float>(i % 11));
  }
  MotionInPicture motion;
  motion.motion = {.exposure_s = 0.02,
                   .readout_s = 0.01,
                   .camera = {.turn_rad_s = {0.0, 0.0, 1.0}},
                   .objects = {{.centre_m = {0.0, 0.0, 1.0}, .velocity_m_s = {9.0, 5.0, 3.0}}}};
  motion.objects = {60, 30, Image<std::int32_t>(40, 50, 0), GrayImage(40, 50, 5.0f)};
  for (std::size_t i = 0; i < scene_.clipped.pixels.size(); i += 3) scene_.clipped.pixels[i] = 1;
  for (std::size_t i = 0; i < scene_.radiance.pixels.size(); i += 17) {
    scene_.radiance.pixels[i] = glm::vec3(-1.0f, 1.0f, 1.0f);
  }
  const struct {
    std::function<void(CompositeInput&)> adapt;
    const char* what;
    // Means along paths are half floats once more, and their cubic weights add up to 1.6 in size.
    float of_means = 0.0f;
  } cases[] = {
      {[&](CompositeInput& input) { input.irradiance_change = &change; }, "a change of light"},
      {[&](CompositeInput& input) { input.sun_shares = &shares; }, "shares of the sun"},
      {[&](CompositeInput& input) {
         input.sun_shares = &shares;
         input.camera_blur_px = 0.3f;
       },
       "blurred shares"},
      {[&](CompositeInput& input) { input.mirrored = &mirrored; }, "mirrored light"},
      {[&](CompositeInput& input) { input.camera_blur_px = 1.5f; }, "blur"},
      {[&](CompositeInput& input) { input.effects.sun_shading = false; }, "no sun on objects"},
      {[&](CompositeInput& input) { input.effects.probe_shading = false; }, "sun alone"},
      {[&](CompositeInput& input) { input.motion = &motion; }, "motion", 4e-3f},
      {[&](CompositeInput& input) {
         input.irradiance_change = &change;
         input.sun_shares = &shares;
         input.mirrored = &mirrored;
         input.camera_blur_px = 0.8f;
         input.motion = &motion;
       },
       "all of it",
       4e-3f}};
  for (const bool is_bent : {false, true}) {
    if (is_bent) BendTheLens();
    for (const auto& [adapt, what, of_means] : cases) {
      adapt_ = adapt;
      of_places_ = of_means;
      EXPECT_GT(ExpectTheSame(std::string(what) + (is_bent ? ", by a bent lens" : "")), 500u);
    }
  }
}

// Light that cannot be, under a picture that has other light, and one pixel that is far brighter
// than all: both give the same, and nothing is brighter than the picture and what shines on it.
TEST_F(CompositeByBoth, IsTheSameUnderLightThatCannotBe) {
  IrradianceChange change{20, 10, RgbImage(140, 110)};
  for (std::size_t i = 0; i < change.irradiance_rgb.pixels.size(); ++i) {
    change.irradiance_rgb.pixels[i] = glm::vec3(static_cast<float>(i % 9) - 4.0f);
  }
  adapt_ = [&](CompositeInput& input) { input.irradiance_change = &change; };
  scene_.radiance.pixels[8000] = glm::vec3(1e6f);
  scene_.clipped.pixels[8100] = 1;
  for (std::size_t i = 0; i < scene_.view.albedo_measured.pixels.size(); i += 2) {
    scene_.view.albedo_measured.pixels[i] = 0;
  }
  const struct {
    glm::dvec3 sun;
    glm::dvec3 sky;
    const char* what;
  } cases[] = {{{800.0, 760.0, 700.0}, {100.0, 130.0, 1e-6}, "a sky without blue"},
               {{800.0, 760.0, 700.0}, {0.0, 0.0, 0.0}, "no sky"},
               {{1e-6, 760.0, 700.0}, {100.0, 130.0, 170.0}, "a sun without red"},
               {{0.0, 0.0, 0.0}, {1e-6, 130.0, 1e-6}, "a green sky"},
               {{8000.0, 7600.0, 7000.0}, {1e-3, 1e-3, 1e-3}, "a sun alone"},
               {{0.0, 0.0, 0.0}, {1e-9, 1e-9, 1e-9}, "hardly any light"}};
  for (const auto& [sun, sky, what] : cases) {
    scene_.lighting.sun.irradiance_rgb = sun;
    scene_.lighting.sky[0].irradiance_rgb = sky;
    const Composite device = Render(CompositeBy::kDevice);
    const Composite processor = Render(CompositeBy::kProcessor);
    EXPECT_GT(ExpectTheSame(device, processor, what), 3000u);
    for (std::size_t i = 0; i < processor.change.pixels.size(); ++i) {
      if (processor.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kScaled)) continue;
      for (int c = 0; c < 3; ++c) {
        const float most = scene_.radiance.pixels[i][c] + 4.0f / 3.14159f;
        ASSERT_LE(processor.radiance.pixels[i][c], 1.0001f * most) << what << ", pixel " << i;
      }
    }
  }
}

// Textures of several sizes, wraps and materials, from near and far, edge-on and cut out, beside
// what is of one colour; on meshes that share no vertices' places, and that move.
TEST_F(CompositeByBoth, IsTheSameOfPicturesOnObjects) {
  of_places_ = 1e-3f;
  const auto fine = Painted(RandomCodes(301, 173, 1));
  const auto coarse = Painted(RandomCodes(9, 5, 2));
  coarse->wraps = {TextureWrap::kMirror, TextureWrap::kClamp};
  coarse->dielectric_reflectance = glm::vec3(0.04f);
  coarse->metallic = 0.4f;
  coarse->roughness = 0.5f;
  const auto cut_out = Painted(RandomCodes(16, 16, 3));
  cut_out->alpha_cutoff = 0.4f;
  const auto unpainted = std::make_shared<TexturedMaterial>();
  const auto around = [](float turns) {
    return [turns](const glm::vec3& p) { return turns * glm::vec2(p.x + 0.7f * p.y, p.z); };
  };
  const Mesh ball = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24);
  const Mesh box = Box({-1.6f, -0.4f, 0.0f}, {-0.7f, 0.5f, 0.9f}, Shiny());
  Mesh coloured = Textured(box, unpainted, around(1.0f));
  for (TriangleColours& colours : coloured.triangle_colours) {
    for (glm::vec4& colour : colours.vertex_colour) colour = glm::vec4(0.2f, 0.9f, 0.5f, 1.0f);
    colours.vertex_colour[1] = glm::vec4(1.0f, 0.1f, 0.7f, 1.0f);
  }
  MirroredLight mirrored{30, 20, RgbImage(90, 80, glm::vec3(3.0f, 5.0f, 2.0f))};
  const struct {
    std::vector<VirtualObject> objects;
    const char* what;
  } cases[] = {{{{Textured(ball, fine, around(1.0f))}}, "a fine one"},
               {{{Textured(ball, fine, around(19.0f))}}, "a fine one many times"},
               {{{Textured(ball, coarse, around(0.7f))}}, "a coarse one on what shines"},
               {{{Textured(ball, cut_out, around(0.9f))}}, "one that is cut out"},
               {{{coloured}}, "colours of vertices"},
               {{{box},
                 {Textured(ball, fine, around(2.0f))},
                 {coloured},
                 {Textured(box, coarse, around(3.0f))},
                 {Textured(Ground(1.5f, 0.4f), cut_out, around(0.8f))}},
                "all together"}};
  for (const bool is_bent : {false, true}) {
    if (is_bent) BendTheLens();
    for (const auto& [objects, what] : cases) {
      for (const bool mirrors : {false, true}) {
        adapt_ = [&](CompositeInput& input) { input.mirrored = mirrors ? &mirrored : nullptr; };
        objects_ = objects;
        EXPECT_GT(ExpectTheSame(std::string(what) + (mirrors ? ", mirroring" : "") +
                                (is_bent ? ", by a bent lens" : "")),
                  500u);
      }
    }
  }
}

// New light on samples that were kept, and on samples found again: bit for bit.
TEST_F(CompositeByBoth, KeptSamplesShowNothingOfFramesBefore) {
  Compositor kept(CompositorOptions{.composite_by = CompositeBy::kProcessor});
  RenderBy(kept);
  const glm::dvec3 sun = scene_.lighting.sun.irradiance_rgb;
  for (const double sunshine : {0.0, 0.3, 1.0}) {
    light_ *= 0.8f;
    scene_.lighting.sun.irradiance_rgb = sunshine * sun;
    scene_.RenderCameraFromModel();
    const Composite still = Again(kept);
    const Composite again = Render(CompositeBy::kProcessor);
    EXPECT_EQ(still.radiance.pixels, again.radiance.pixels) << sunshine;
    EXPECT_EQ(still.change.pixels, again.change.pixels) << sunshine;
    EXPECT_LT(still.draw_calls, again.draw_calls);
  }
}

// A cloudy frame has no pass of the sun's: neither on objects nor on surfaces.
TEST_F(CompositeByBoth, WithoutSunNothingIsDrawnForIt) {
  Compositor compositor(CompositorOptions{.composite_by = CompositeBy::kProcessor});
  RenderBy(compositor);
  const int in_the_sun = Again(compositor).draw_calls;
  scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  const int under_cloud = Again(compositor).draw_calls;
  EXPECT_EQ(under_cloud, 2);  // The objects' layer, and its composite.
  EXPECT_GT(in_the_sun, under_cloud);
}

}  // namespace
}  // namespace pleinair::test::composite_by_both_test
