// Pictures on surfaces: places near and far, and means that are those of light.
#include "scene/texture.h"

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/textured_material.h"

namespace pleinair::texture_test {
namespace {

constexpr TextureWraps kRepeat{TextureWrap::kRepeat, TextureWrap::kRepeat};

Texture::Codes RandomCodes(int width, int height) {
  std::mt19937 random(5);
  Texture::Codes codes(width, height);
  for (glm::u8vec4& code : codes.pixels) {
    code = glm::u8vec4(random() % 256, random() % 256, random() % 256, random() % 256);
  }
  return codes;
}

// IEC 61966-2-1, in double.
double Linear(int code) {
  const double value = code / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double HalfACode(double linear) {
  int code = 0;
  while (code < 254 && Linear(code + 1) < linear) ++code;
  return 0.5 * (Linear(code + 1) - Linear(code)) + 1e-6;
}

TEST(TextureTest, ShowsItsTexelsAtTheirMiddles) {
  const Texture::Codes codes = RandomCodes(5, 3);
  const Texture texture{Texture::Codes(codes)};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (const float turns : {0.0f, -3.0f, 7.0f}) {
        const glm::vec2 uv = (glm::vec2(x, y) + 0.5f) / glm::vec2(5.0f, 3.0f) + turns;
        const glm::vec4 shown = texture.At(uv, 0.0f, kRepeat);
        // A place is good to 1e-6 of 5 texels, whole turns included.
        EXPECT_NEAR(shown.r, Linear(codes.At(x, y).r), 1e-5);
        EXPECT_NEAR(shown.b, Linear(codes.At(x, y).b), 1e-5);
        EXPECT_NEAR(shown.a, codes.At(x, y).a / 255.0, 1e-5);
      }
    }
  }
}

TEST(TextureTest, GoesLinearlyFromTexelToTexelAndOverTheEdgeAsItsSamplerStates) {
  Texture::Codes codes(2, 1);
  codes.At(0, 0) = glm::u8vec4(0, 0, 0, 255);
  codes.At(1, 0) = glm::u8vec4(255);
  const Texture texture(std::move(codes));
  const auto at = [&](float u, TextureWrap wrap) {
    return texture.At({u, 0.5f}, 0.0f, {wrap, wrap}).g;
  };
  for (const TextureWrap wrap : {TextureWrap::kRepeat, TextureWrap::kMirror, TextureWrap::kClamp}) {
    EXPECT_NEAR(at(0.5f, wrap), 0.5f, 1e-6f);
    EXPECT_NEAR(at(0.35f, wrap), 0.2f, 1e-6f);
  }
  // Its edge is a seam, a mirror, or the end.
  EXPECT_NEAR(at(1.0f, TextureWrap::kRepeat), 0.5f, 1e-6f);
  EXPECT_NEAR(at(1.0f, TextureWrap::kMirror), 1.0f, 1e-6f);
  EXPECT_NEAR(at(1.0f, TextureWrap::kClamp), 1.0f, 1e-6f);
  EXPECT_NEAR(at(1.25f, TextureWrap::kRepeat), 0.0f, 1e-6f);
  EXPECT_NEAR(at(1.25f, TextureWrap::kMirror), 1.0f, 1e-6f);
  EXPECT_NEAR(at(1.75f, TextureWrap::kMirror), 0.0f, 1e-6f);
  EXPECT_NEAR(at(-0.25f, TextureWrap::kMirror), 0.0f, 1e-6f);
  EXPECT_NEAR(at(-0.75f, TextureWrap::kMirror), 1.0f, 1e-6f);
  EXPECT_NEAR(at(9.0f, TextureWrap::kClamp), 1.0f, 1e-6f);
  EXPECT_NEAR(at(-9.0f, TextureWrap::kClamp), 0.0f, 1e-6f);
}

// For any size: no texel counts more than another. The mean of the codes would be far darker.
TEST(TextureTest, LevelsHaveTheMeanOfTheLight) {
  for (const glm::ivec2 size : {glm::ivec2(64, 64),
                                glm::ivec2(37, 23),
                                glm::ivec2(1, 1),
                                glm::ivec2(1, 9),
                                glm::ivec2(255, 2)}) {
    const Texture::Codes codes = RandomCodes(size.x, size.y);
    double mean = 0.0;
    for (const glm::u8vec4& code : codes.pixels) mean += Linear(code.g);
    mean /= static_cast<double>(codes.pixels.size());
    const Texture texture{Texture::Codes(codes)};
    EXPECT_NEAR(texture.Mean().g, mean, 1e-6);
    const int last = texture.LevelCount() - 1;
    EXPECT_EQ(last, static_cast<int>(std::floor(std::log2(std::max(size.x, size.y)))));
    EXPECT_EQ(texture.Level(last).pixels.size(), 1u);
    // Rounded to codes once, however many levels are between.
    EXPECT_NEAR(Linear(texture.Level(last).At(0, 0).g), mean, HalfACode(mean))
        << size.x << "x" << size.y;
  }
}

TEST(TextureTest, ALevelIsTheOneWhoseTexelsAreAsWideAsAStep) {
  const Texture texture(RandomCodes(64, 16));
  EXPECT_EQ(texture.LevelFor({1.0f / 64.0f, 0.0f}, {0.0f, 1.0f / 16.0f}), 0.0f);
  EXPECT_NEAR(texture.LevelFor({4.0f / 64.0f, 0.0f}, {0.0f, 1.0f / 16.0f}), 2.0f, 1e-5f);
  EXPECT_NEAR(texture.LevelFor({0.0f, 0.0f}, {0.0f, 8.0f / 16.0f}), 3.0f, 1e-5f);
  EXPECT_EQ(texture.LevelFor({1e-9f, 0.0f}, {0.0f, 0.0f}), 0.0f);
  EXPECT_EQ(texture.LevelFor({1e9f, 0.0f}, {0.0f, 0.0f}), 6.0f);
  const float nan = std::nanf("");
  EXPECT_EQ(texture.LevelFor({nan, 0.0f}, {0.0f, 0.0f}), 6.0f);
  EXPECT_EQ(texture.LevelFor({INFINITY, 0.0f}, {0.0f, 0.0f}), 6.0f);
  // Half way between two levels is their mean.
  const glm::vec2 uv(0.3f, 0.8f);
  EXPECT_LT(glm::distance(texture.At(uv, 1.5f, kRepeat),
                          0.5f * (texture.At(uv, 1.0f, kRepeat) + texture.At(uv, 2.0f, kRepeat))),
            1e-6f);
}

// Halves of black and white: what of the triangle lies in which counts.
TEST(TextureTest, TheMeanOverATriangleIsThatOfWhatItCovers) {
  Texture::Codes codes(512, 512);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 512; ++x) codes.At(x, y) = glm::u8vec4(x < 256 ? 0 : 255);
  }
  const Texture texture(std::move(codes));
  const auto mean = [&](glm::vec2 a, glm::vec2 b, glm::vec2 c) {
    return texture.MeanOver({a, b, c}, kRepeat).r;
  };
  // Tolerance by the texels of the level used, 16 to the triangle's side: a quarter of such a
  // column of a triangle that has an eighth of its area along an edge.
  EXPECT_NEAR(mean({0, 0}, {1, 0}, {0, 1}), 0.25f, 0.02f);
  EXPECT_NEAR(mean({1, 0}, {1, 1}, {0, 1}), 0.75f, 0.02f);
  EXPECT_NEAR(mean({0.1f, 0.1f}, {0.4f, 0.1f}, {0.1f, 0.4f}), 0.0f, 1e-6f);
  // Nine periods, each with less of its white half: sum of (8.25 - k) / 81.
  EXPECT_NEAR(mean({0, 0}, {9, 0}, {0, 9}), 38.25f / 81.0f, 0.02f);
  EXPECT_EQ(mean({0.7f, 0.5f}, {0.7f, 0.5f}, {0.7f, 0.5f}), 1.0f);
}

// What is cut out has no colour, whatever its texels hold.
TEST(TextureTest, TheMeanOfWhatIsThereLeavesOutWhatIsNot) {
  Texture::Codes codes(64, 64, glm::u8vec4(255, 255, 255, 0));
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) codes.At(x, y) = glm::u8vec4(188, 0, 0, 255);
  }
  const Texture texture(std::move(codes));
  const std::array<glm::vec2, 3> whole{glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1)};
  const glm::vec3 there = texture.MeanOver(whole, kRepeat, Texture::Of::kWhatIsThere);
  EXPECT_NEAR(there.r, Linear(188), 0.02);  // A texel at the edge of 16 rows is half there.
  EXPECT_NEAR(there.g, 0.0f, 0.02f);
  EXPECT_GT(texture.MeanOver(whole, kRepeat).g, 0.2f);
  const std::array<glm::vec2, 3> nowhere{
      glm::vec2(0.2f, 0.6f), glm::vec2(0.4f, 0.6f), glm::vec2(0.2f, 0.9f)};
  EXPECT_NEAR(texture.MeanOver(nowhere, kRepeat, Texture::Of::kWhatIsThere).g, 1.0f, 1e-6f);
}

TEST(TextureTest, APictureThatIsTooLargeIsTakenAtHalfItsSize) {
  Texture::Codes codes(4100, 4100, glm::u8vec4(188, 10, 255, 255));
  const Texture texture(std::move(codes));
  EXPECT_EQ(texture.Width(), 2050);
  EXPECT_EQ(texture.TimesHalved(), 1);
  EXPECT_EQ(texture.Level(0).At(2000, 7), glm::u8vec4(188, 10, 255, 255));
  EXPECT_EQ(texture.Level(11).At(0, 0), glm::u8vec4(188, 10, 255, 255));
  EXPECT_THROW(Texture{Texture::Codes()}, std::invalid_argument);
}

TEST(TextureTest, AMaterialMultipliesFactorVertexColourAndTexture) {
  TexturedMaterial material;
  material.texture =
      std::make_shared<const Texture>(Texture::Codes(1, 1, glm::u8vec4(188, 255, 0, 255)));
  material.base_colour = {0.8f, 0.4f, 1.0f};
  material.dielectric_reflectance = glm::vec3(0.04f);
  material.metallic = 0.25f;
  const glm::vec4 colour = material.ColourAt({0.2f, 0.9f}, 0.0f, {0.5f, 0.5f, 0.5f, 0.5f});
  EXPECT_FLOAT_EQ(colour.a, 0.5f);
  const TexturedMaterial::Reflectances here = material.Of(glm::vec3(colour));
  EXPECT_NEAR(here.diffuse_albedo.r, 0.75 * 0.8 * 0.5 * Linear(188), 1e-6);
  EXPECT_NEAR(here.diffuse_albedo.g, 0.75 * 0.4 * 0.5, 1e-6);
  EXPECT_NEAR(here.specular_reflectance.g, 0.75 * 0.04 + 0.25 * 0.4 * 0.5, 1e-6);
  EXPECT_EQ(here.diffuse_albedo.b, 0.0f);
  TriangleColours colours;
  EXPECT_TRUE(material.IsEvenOver(colours));
  colours.vertex_colour[1] = glm::vec4(0.2f, 1.0f, 1.0f, 1.0f);
  EXPECT_FALSE(material.IsEvenOver(colours));
}

}  // namespace
}  // namespace pleinair::texture_test
