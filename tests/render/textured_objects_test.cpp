// Pictures on virtual objects, by both composites: texels from near, the mean of their light from
// afar, what is cut out.
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "test_scenes.h"
#include "textured_meshes.h"

namespace pleinair::test::textured_objects_test {
namespace {

// Half floats that may be cut off instead of rounded, 2^-10 each: the texture, a sample, the mean,
// the composite.
constexpr double kRounding = 4e-3;
constexpr float kIrradiance = 90.0f;
constexpr int kWidth = 96;
constexpr int kHeight = 72;

double LinearOf(int code) {
  const double value = code / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

class TexturedObjects : public testing::TestWithParam<CompositeBy> {
 protected:
  // The camera looks to the north along the ground, 4 m before a board that is 4 pixels wide for
  // each 0.1 m.
  TexturedObjects() {
    scene_.view.camera = LookAt({0.0, -4.0, 1.5}, {0.0, 0.0, 1.5}, kWidth, kHeight, 160.0);
    scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
    scene_.SetIntrinsics(scene_.view.camera.intrinsics);
    compositor_.SetPhantom(scene_.phantom);
  }

  // Faces the camera, `half_px` to each side of the picture's middle moved by `shift_px`.
  static Mesh Board(const std::shared_ptr<const TexturedMaterial>& material,
                    float half_px,
                    float shift_px,
                    float repeats) {
    const float half_m = half_px / 40.0f;
    const float shift_m = shift_px / 40.0f;
    Mesh board = MeshOf({{shift_m - half_m, 0.0f, 1.5f - half_m},
                         {shift_m + half_m, 0.0f, 1.5f - half_m},
                         {shift_m + half_m, 0.0f, 1.5f + half_m},
                         {shift_m - half_m, 0.0f, 1.5f + half_m}},
                        {{0, 1, 2}, {0, 2, 3}},
                        {});
    return Textured(std::move(board), material, [&](const glm::vec3& p) {
      return repeats * (glm::vec2(p.x - shift_m, 1.5f - p.z) / (2.0f * half_m) + 0.5f);
    });
  }

  Composite Render(const Mesh& object) {
    compositor_.SetObjects({{object}});
    vertex_irradiance_ = {
        std::vector<glm::vec3>(object.positions_m.size(), glm::vec3(kIrradiance))};
    CompositeInput input = scene_.Input(vertex_irradiance_);
    adapt_(input);
    return compositor_.Render(input);
  }

  HeadlessContext context_;
  Compositor compositor_{CompositorOptions{.composite_by = GetParam()}};
  CompositeScene scene_{DirectionOf(215.0, 40.0), kWidth, kHeight};
  std::function<void(CompositeInput&)> adapt_ = [](CompositeInput&) {};
  std::vector<std::vector<glm::vec3>> vertex_irradiance_;
};

// Each texel of a board of 7 x 7 is 8 pixels wide. What is between texels is
// known by their own formula, and a pixel shows a mean over its square, here by 16 places.
TEST_P(TexturedObjects, ABoardSeenFaceOnShowsItsTexels) {
  const Texture::Codes codes = RandomCodes(7, 7, 3);
  const auto material = Painted(Texture::Codes(codes));
  const Composite composite = Render(Board(material, 28.0f, 0.0f, 1.0f));
  // LookAt's principal point.
  const double centre_x = scene_.Camera().intrinsics.cx_px;
  const double centre_y = scene_.Camera().intrinsics.cy_px;
  const auto texel = [&](int x, int y, int c) {
    return LinearOf(codes.At((x + 7) % 7, (y + 7) % 7)[c]);
  };
  const auto shown = [&](double x_px, double y_px, int c) {
    const double x = (x_px - centre_x) / 8.0 + 3.5 - 0.5;
    const double y = (y_px - centre_y) / 8.0 + 3.5 - 0.5;
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    const double u = x - left;
    const double v = y - top;
    return (1 - v) * ((1 - u) * texel(left, top, c) + u * texel(left + 1, top, c)) +
           v * ((1 - u) * texel(left, top + 1, c) + u * texel(left + 1, top + 1, c));
  };
  int compared = 0;
  for (int y = 10; y < kHeight - 10; ++y) {
    for (int x = 22; x < kWidth - 22; ++x) {
      const std::size_t pixel = composite.change.Index(x, y);
      ASSERT_EQ(composite.change.pixels[pixel], static_cast<std::uint8_t>(PixelChange::kCovered));
      for (int c = 0; c < 3; ++c) {
        double mean = 0.0;
        for (int sample = 0; sample < 16; ++sample) {
          mean += shown(x - 0.375 + 0.25 * (sample % 4), y - 0.375 + 0.25 * (sample / 4), c) / 16.0;
        }
        const double expected = 0.9 * mean * kIrradiance / std::numbers::pi;
        // OpenGL moves corners by up to 2^-8 of a sample: that much of a texel next to it.
        EXPECT_NEAR(composite.radiance.pixels[pixel][c],
                    expected,
                    kRounding * std::max(expected, 0.1) + 1.0 / 256.0 / 32.0 * kIrradiance)
            << x << ", " << y;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 3000);
}

// 16 texels to a pixel: half the light of white, wherever the board moves. The mean of the codes
// would be a fifth.
TEST_P(TexturedObjects, AFinePatternFromAfarIsTheMeanOfItsLight) {
  Texture::Codes codes(255, 255);  // Odd on purpose.
  int white = 0;
  for (int y = 0; y < 255; ++y) {
    for (int x = 0; x < 255; ++x) {
      white += (x + y) % 2;
      codes.At(x, y) = (x + y) % 2 != 0 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255);
    }
  }
  const auto material = Painted(std::move(codes));
  const double expected = 0.9 * white / (255.0 * 255.0) * kIrradiance / std::numbers::pi;
  // 188 is the code that comes nearest to half the light.
  const double of_a_code = 0.5 * (LinearOf(188) - LinearOf(187)) * kIrradiance / std::numbers::pi;
  for (const float shift_px : {0.0f, 0.3f, 0.77f}) {
    for (const float repeats : {1.0f, 3.5f}) {
      const Composite composite = Render(Board(material, 16.0f, shift_px, repeats));
      for (int y = kHeight / 2 - 12; y < kHeight / 2 + 12; ++y) {
        for (int x = kWidth / 2 - 12; x < kWidth / 2 + 12; ++x) {
          const glm::vec3& shown = composite.radiance.At(x, y);
          EXPECT_NEAR(shown.g, expected, of_a_code + kRounding * expected)
              << shift_px << ", " << repeats << " at " << x << ", " << y;
        }
      }
    }
  }
}

// The same albedo as a texture's and as a material's own, in the sun.
TEST_P(TexturedObjects, AnEvenTextureIsAMaterialOfItsColour) {
  scene_.lighting.sun.irradiance_rgb = {800.0, 760.0, 700.0};
  scene_.RenderCameraFromModel();
  auto material = Painted(Texture::Codes(3, 2, glm::u8vec4(188, 100, 30, 255)));
  material->dielectric_reflectance = glm::vec3(0.04f);
  material->metallic = 0.3f;
  material->roughness = 0.4f;
  const Mesh sphere = Sphere({0.0f, 0.0f, 1.5f}, 0.5f, 24);
  const Mesh textured =
      Textured(sphere, material, [](const glm::vec3& p) { return glm::vec2(p.x, p.z); });
  Mesh plain = sphere;
  plain.materials[0] = material->Mean();
  MirroredLight mirrored{0, 0, RgbImage(kWidth, kHeight, glm::vec3(2.0f, 3.0f, 4.0f))};
  for (const bool mirrors : {false, true, false}) {
    adapt_ = [&](CompositeInput& input) { input.mirrored = mirrors ? &mirrored : nullptr; };
    const Composite found = Render(textured);
    const Composite expected = Render(plain);
    EXPECT_EQ(found.change.pixels, expected.change.pixels);
    for (std::size_t i = 0; i < found.radiance.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found.radiance.pixels[i][c],
                    expected.radiance.pixels[i][c],
                    kRounding * expected.radiance.pixels[i][c])
            << i << (mirrors ? ", mirroring" : "");
      }
    }
  }
}

// Colours of vertices alone: linear between them.
TEST_P(TexturedObjects, ColoursOfVerticesGoFromOneToTheOther) {
  auto material = std::make_shared<TexturedMaterial>();
  material->base_colour = glm::vec3(0.8f);
  Mesh board = Board(material, 20.0f, 0.0f, 1.0f);
  for (TriangleColours& colours : board.triangle_colours) {
    for (std::size_t k = 0; k < 3; ++k) {
      colours.vertex_colour[k] = glm::vec4(colours.texture_uv[k].x, 1.0f, 0.5f, 1.0f);
    }
  }
  const Composite composite = Render(board);
  for (const int x : {35, 48, 60}) {
    const double share = (x - scene_.Camera().intrinsics.cx_px + 20.0) / 40.0;
    const double white = 0.8 * kIrradiance / std::numbers::pi;
    const glm::vec3& shown = composite.radiance.At(x, kHeight / 2);
    EXPECT_NEAR(shown.r, share * white, kRounding * white);
    EXPECT_NEAR(shown.g, white, kRounding * white);
    EXPECT_NEAR(shown.b, 0.5 * white, kRounding * white);
  }
}

// The left half is not there: neither its light nor, in the sun, its glint.
TEST_P(TexturedObjects, WhatAMaskCutsOutIsTransparent) {
  Texture::Codes codes(8, 8, glm::u8vec4(200, 150, 90, 255));
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 4; ++x) codes.At(x, y).a = 0;
  }
  auto material = Painted(std::move(codes));
  material->alpha_cutoff = 0.5f;
  material->wraps = {TextureWrap::kClamp, TextureWrap::kClamp};
  for (const double sun : {0.0, 800.0}) {
    scene_.lighting.sun.irradiance_rgb = glm::dvec3(sun);
    scene_.RenderCameraFromModel();
    adapt_ = [](CompositeInput& input) { input.effects.sun_shadow = false; };
    const Composite composite = Render(Board(material, 20.0f, 0.0f, 1.0f));
    // The middle lies between two pixels or in one; half of what covers is at alpha 0.5 there.
    for (int y = kHeight / 2 - 15; y < kHeight / 2 + 15; ++y) {
      for (int x = kWidth / 2 - 15; x <= kWidth / 2 - 2; ++x) {
        const std::size_t pixel = composite.change.Index(x, y);
        ASSERT_EQ(composite.change.pixels[pixel], 0) << x << ", " << y;
        ASSERT_EQ(composite.radiance.pixels[pixel], scene_.radiance.pixels[pixel]);
      }
      for (int x = kWidth / 2 + 2; x < kWidth / 2 + 15; ++x) {
        ASSERT_EQ(composite.change.At(x, y), static_cast<std::uint8_t>(PixelChange::kCovered));
        EXPECT_GT(composite.radiance.At(x, y).r, 5.0f);
      }
    }
  }
}

TEST_P(TexturedObjects, DesktopAndEmbeddedOpenGlShowTheSame) {
  scene_.lighting.sun.irradiance_rgb = {800.0, 760.0, 700.0};
  scene_.RenderCameraFromModel();
  const auto material = Painted(RandomCodes(33, 21, 9));
  material->wraps = {TextureWrap::kMirror, TextureWrap::kRepeat};
  material->alpha_cutoff = 0.3f;
  const Mesh sphere = Textured(Sphere({0.0f, 0.0f, 1.5f}, 0.6f, 24),
                               material,
                               [](const glm::vec3& p) { return glm::vec2(2.0f * p.x, p.z); });
  const Composite desktop = Render(sphere);
  const HeadlessContext es_context(GlApi::kEs31);
  Compositor es_compositor(CompositorOptions{.composite_by = GetParam()});
  es_compositor.SetPhantom(scene_.phantom);
  es_compositor.SetObjects({{sphere}});
  const Composite es = es_compositor.Render(scene_.Input(vertex_irradiance_));
  std::size_t different = 0;
  std::size_t covered = 0;
  std::size_t apart = 0;
  for (std::size_t i = 0; i < desktop.change.pixels.size(); ++i) {
    if (desktop.change.pixels[i] != es.change.pixels[i]) {
      ++different;
    } else if (es.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) {
      ++covered;
      const float expected = desktop.radiance.pixels[i].g;
      apart += std::abs(es.radiance.pixels[i].g - expected) > kRounding * expected ? 1 : 0;
    }
  }
  EXPECT_LE(different, desktop.change.pixels.size() / 1000);
  EXPECT_GT(covered, 500u);
  // Triangles seen from their edge, where a sample's place lies outside by a part of its width: the
  // processor keeps samples with desktop OpenGL alone, and takes them back inside.
  EXPECT_LE(apart, covered / 100);
}

TEST_P(TexturedObjects, WhatMakesNoSenseIsRefusedByName) {
  const auto material = Painted(RandomCodes(4, 4, 1));
  const auto message = [&](Mesh mesh) -> std::string {
    try {
      compositor_.SetObjects({{std::move(mesh)}});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Mesh board = Board(material, 20.0f, 0.0f, 1.0f);
  EXPECT_EQ(message(board), "");
  for (const auto& [value, name] : {std::pair{std::numeric_limits<float>::infinity(), "inf"},
                                    std::pair{std::numeric_limits<float>::quiet_NaN(), "nan"},
                                    std::pair{2e6f, "2000000.000000"}}) {
    board.triangle_colours[1].texture_uv[0].y = value;
    EXPECT_EQ(message(board),
              std::string("objects[0].mesh: triangle_colours[1] holds ") + name +
                  ", expected numbers of at most a million");
  }
  board.triangle_colours.pop_back();
  EXPECT_EQ(message(board),
            "objects[0].mesh: triangle_colours has 1 entries, expected 2, one a triangle");
}

INSTANTIATE_TEST_SUITE_P(By, TexturedObjects, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::textured_objects_test
