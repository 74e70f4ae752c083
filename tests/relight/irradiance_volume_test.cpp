#include "relight/volume/irradiance_volume.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relight/volume/vertex_irradiance.h"
#include "scene/sky_shape.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::irradiance_volume_test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
const glm::dvec3 kSun = glm::normalize(glm::dvec3(-0.5, 0.3, 0.6));
const glm::vec3 kUp(0.0f, 0.0f, 1.0f);

std::vector<glm::vec3> SkyRadiance(const ProbeOperator& probes, const SkyShape& shape) {
  std::vector<glm::vec3> radiance;
  for (const glm::vec3& direction : probes.SkyDirections()) {
    radiance.push_back(shape.Radiance(direction));
  }
  return radiance;
}

// Brighter and redder to the west: what a second shape may be like.
std::shared_ptr<const SkyShape> WesternSky() {
  const LatLongSize size{64, 32};
  RgbImage sky(size.width, size.height);
  for (int y = 0; y < size.height / 2; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::dvec3 d = DirectionFromLatLong({x + 0.5, y + 0.5}, size);
      const auto west = static_cast<float>(std::max(0.0, -d.x));
      sky.At(x, y) = {1.0f + 4.0f * west, 1.0f + 2.0f * west, 1.0f};
    }
  }
  return MakeImageSkyShape("western", sky);
}

// The yard with everything that light may come through: map, faces behind what the map sees, sky
// that a house hides from it; sun and two sky shapes.
struct LitYard {
  PatchScene scene = Yard();
  Survey survey = SurveyOf(scene, {0.0, 0.0, 1.5}, {128, 64}, kSun, 2);
  std::vector<std::shared_ptr<const SkyShape>> shapes{MakeUniformSkyShape(), WesternSky()};
  ProbeOperator probes{
      scene, &survey, MakeProbeGrid({{-2.0f, -3.0f, 0.0f}, {11.0f, 3.0f, 3.0f}}, {6, 4, 4}), {}};
  BasisLights basis;

  LitYard() {
    basis.environment.push_back(EnvironmentOfSun(survey, kSun));
    basis.face_radiosity.push_back(FaceLight(0));
    basis.sky_radiance.emplace_back();
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      basis.environment.push_back(EnvironmentOfSky(survey, k, *shapes[k]));
      basis.face_radiosity.push_back(FaceLight(k + 1));
      basis.sky_radiance.push_back(SkyRadiance(probes, *shapes[k]));
    }
  }

  // Any radiosities will do; these differ from face to face and light to light.
  std::vector<glm::vec3> FaceLight(std::size_t light) const {
    std::vector<glm::vec3> radiosity(scene.FaceCount());
    for (std::size_t i = 0; i < radiosity.size(); ++i) {
      const auto x = static_cast<float>(7 * i + 3 * light);
      radiosity[i] = glm::vec3(0.3f) + 0.2f * glm::vec3(std::sin(x), std::cos(x), std::sin(2 * x));
    }
    return radiosity;
  }
};

Lighting SunAndTwoSkies(const glm::dvec3& sun, const glm::dvec3& uniform, const glm::dvec3& west) {
  Lighting lighting;
  lighting.sun.irradiance_rgb = sun;
  lighting.sky = {{"uniform", uniform}, {"western", west}};
  return lighting;
}

const Lighting kDay = SunAndTwoSkies({800, 750, 690}, {60, 70, 90}, {40, 45, 55});

double LargestApart(const std::vector<ShRgb>& a, const std::vector<ShRgb>& b) {
  double apart = 0.0;
  for (std::size_t p = 0; p < a.size(); ++p) {
    for (std::size_t j = 0; j < a[p].size(); ++j) {
      for (glm::length_t c = 0; c < 3; ++c) {
        apart = std::max(apart, std::abs(static_cast<double>(a[p][j][c]) - b[p][j][c]));
      }
    }
  }
  return apart;
}

double LargestOf(const std::vector<ShRgb>& a) {
  return LargestApart(a, std::vector<ShRgb>(a.size(), ShRgb{}));
}

// A volume of one cell over nothing but sky.
IrradianceVolume OpenField(const SkyShape& shape, const glm::dvec3& irradiance_rgb) {
  const PatchScene nothing = SceneOf({});
  const ProbeGrid grid = MakeProbeGrid({glm::vec3(0.0f), glm::vec3(1.0f)}, {2, 2, 2});
  const ProbeOperator probes(nothing, nullptr, grid, {});
  const BasisLights basis{std::vector<EnvironmentBasis>(2),
                          std::vector<std::vector<glm::vec3>>(2),
                          {{}, SkyRadiance(probes, shape)}};
  Lighting lighting;
  lighting.sky = {{shape.Name(), irradiance_rgb}};
  IrradianceVolume volume;
  FoldedVolume(probes, basis).Combine(lighting, {}, volume);
  return volume;
}

// Three bands give an open uniform sky's irradiance on a plane facing up or down, or standing,
// without error: 1, 0 and 1/2 of the horizontal. 0.2 % for the quadrature.
TEST(IrradianceVolume, AnOpenUniformSkyLightsByTheShareOfItThatASurfaceFaces) {
  const glm::dvec3 sky(100.0, 200.0, 400.0);
  const IrradianceVolume volume = OpenField(*MakeUniformSkyShape(), sky);
  const glm::vec3 middle(0.4f, 0.5f, 0.6f);
  for (glm::length_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(volume.Irradiance(middle, kUp)[c], sky[c], 0.002 * sky[c]);
    EXPECT_NEAR(volume.Irradiance(middle, -kUp)[c], 0.0, 0.002 * sky[c]);
    for (const glm::vec3& side : {glm::vec3(1, 0, 0), glm::vec3(0, -1, 0)}) {
      EXPECT_NEAR(volume.Irradiance(middle, side)[c], 0.5 * sky[c], 0.002 * sky[c]);
    }
  }
}

// Over a wide ground of albedo 0.3 that the sky alone lights, a plane facing down gets 0.3 of the
// horizontal. 0.2 % for the quadrature, 0.1 % for the ground's end.
TEST(IrradianceVolume, TheGroundSendsItsAlbedoBack) {
  Mesh mesh;
  AddGround(mesh, 2000.0f);
  const PatchScene plane = SceneOf(std::move(mesh), glm::vec3(0.3f));
  const ProbeGrid grid = MakeProbeGrid({{-1, -1, 0}, {1, 1, 2}}, {3, 3, 3});
  const ProbeOperator probes(plane, nullptr, grid, {});
  std::vector<glm::vec3> radiosity(plane.FaceCount(), glm::vec3(0.0f));
  radiosity[0] = radiosity[2] = glm::vec3(0.3f);  // The upper faces.
  const BasisLights basis{std::vector<EnvironmentBasis>(2),
                          {{}, radiosity},
                          {{}, SkyRadiance(probes, *MakeUniformSkyShape())}};
  Lighting lighting;
  lighting.sky = {{"uniform", glm::dvec3(1.0)}};
  IrradianceVolume volume;
  FoldedVolume(probes, basis).Combine(lighting, {}, volume);
  for (const float height_m : {0.0f, 0.7f, 2.0f}) {
    const glm::vec3 point(0.2f, -0.3f, height_m);
    EXPECT_NEAR(volume.Irradiance(point, kUp).x, 1.0f, 0.003f);
    EXPECT_NEAR(volume.Irradiance(point, -kUp).x, 0.3f, 0.003f);
  }
}

// The bar is 1e-4 relative; both routes add up the same float products in another order, which
// leaves some 1e-6 of the largest coefficient.
TEST(IrradianceVolume, BothRoutesGiveTheSameProbes) {
  const LitYard yard;
  RgbImage environment;
  SynthesiseEnvironment(yard.basis.environment, kDay, environment);
  const IrradianceVolume by_map = VolumeFromEnvironment(yard.probes, yard.basis, environment, kDay);
  IrradianceVolume folded;
  FoldedVolume(yard.probes, yard.basis).Combine(kDay, {}, folded);
  ASSERT_GT(LargestOf(folded.probes), 0.0);
  EXPECT_LT(LargestApart(by_map.probes, folded.probes), 2e-6 * LargestOf(folded.probes));
  EXPECT_EQ(by_map.valid, folded.valid);
  // Coefficient by coefficient, where one is not a small difference of large numbers.
  for (std::size_t p = 0; p < folded.probes.size(); ++p) {
    for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
      for (glm::length_t c = 0; c < 3; ++c) {
        const float expected = folded.probes[p][j][c];
        if (std::abs(expected) < 0.01f * folded.probes[p][0][c]) continue;
        EXPECT_NEAR(by_map.probes[p][j][c], expected, 1e-4f * std::abs(expected));
      }
    }
  }
}

// All three ways that light takes into this volume are in use, or the test above says little.
TEST(IrradianceVolume, TheYardSeesMapPatchesAndHiddenSky) {
  const LitYard yard;
  const std::vector<glm::vec3> map(128 * 64, glm::vec3(1.0f));
  const std::vector<glm::vec3> faces(yard.scene.FaceCount(), glm::vec3(1.0f));
  const std::vector<glm::vec3> sky(yard.probes.SkyDirections().size(), glm::vec3(1.0f));
  EXPECT_GT(LargestOf(yard.probes.Apply(map, {}, {})), 0.3);
  EXPECT_GT(LargestOf(yard.probes.Apply({}, faces, {})), 0.3);
  EXPECT_GT(LargestOf(yard.probes.Apply({}, {}, sky)), 0.3);
  EXPECT_NE(std::count(yard.probes.Valid().begin(), yard.probes.Valid().end(), 0), 0);
}

TEST(IrradianceVolume, IsLinearInTheLight) {
  const LitYard yard;
  const FoldedVolume folded(yard.probes, yard.basis);
  const Lighting one = SunAndTwoSkies({900, 10, 300}, {5, 0, 80}, {0, 60, 1});
  const Lighting two = SunAndTwoSkies({0, 500, 30}, {70, 20, 0}, {9, 8, 200});
  const double a = 1.7, b = 0.4;
  Lighting mixed = one;
  mixed.sun.irradiance_rgb = a * one.sun.irradiance_rgb + b * two.sun.irradiance_rgb;
  for (std::size_t k = 0; k < 2; ++k) {
    mixed.sky[k].irradiance_rgb = a * one.sky[k].irradiance_rgb + b * two.sky[k].irradiance_rgb;
  }
  IrradianceVolume volume_one, volume_two, volume_mixed;
  folded.Combine(one, {}, volume_one);
  folded.Combine(two, {}, volume_two);
  folded.Combine(mixed, {}, volume_mixed);
  std::vector<ShRgb> sum = volume_one.probes;
  for (std::size_t p = 0; p < sum.size(); ++p) {
    for (std::size_t j = 0; j < sum[p].size(); ++j) {
      sum[p][j] =
          static_cast<float>(a) * sum[p][j] + static_cast<float>(b) * volume_two.probes[p][j];
    }
  }
  EXPECT_LT(LargestApart(volume_mixed.probes, sum), 1e-5 * LargestOf(sum));
}

TEST(IrradianceVolume, RefoldingTheSunIsTheSameAsFolding) {
  LitYard yard;
  FoldedVolume kept(yard.probes, yard.basis);
  yard.basis.environment[0] = EnvironmentOfSun(yard.survey, {0.0, 0.0, 1.0});
  yard.basis.face_radiosity[0] = yard.FaceLight(5);
  kept.Refold(yard.probes, yard.basis, 0);
  IrradianceVolume refolded, again;
  kept.Combine(kDay, {}, refolded);
  FoldedVolume(yard.probes, yard.basis).Combine(kDay, {}, again);
  EXPECT_EQ(refolded.probes, again.probes);
}

// Trilinear interpolation gives a field back that is linear in position. Two roundings of a float
// for each of eight terms.
TEST(IrradianceVolume, ReproducesALinearField) {
  IrradianceVolume volume;
  volume.grid = MakeProbeGrid({{-1.0f, 2.0f, 0.0f}, {3.0f, 5.0f, 2.0f}}, {5, 3, 2});
  volume.valid.assign(volume.grid.ProbeCount(), 1);
  const auto field = [](const glm::vec3& p) {
    return 10.0f + 2.0f * p.x - 1.5f * p.y + 3.0f * p.z;
  };
  for (std::size_t i = 0; i < volume.grid.ProbeCount(); ++i) {
    ShRgb sh{};
    sh[0] = glm::vec3(field(volume.grid.PositionM(i)));
    volume.probes.push_back(sh);
  }
  const float factor = kPi * std::sqrt(1.0f / (4.0f * kPi));  // A_0 Y_00.
  for (const glm::vec3& p : {glm::vec3(0.0f, 3.0f, 1.0f),
                             glm::vec3(2.9f, 2.1f, 0.3f),
                             glm::vec3(-1.0f, 5.0f, 2.0f),
                             glm::vec3(3.0f, 5.0f, 2.0f)}) {
    EXPECT_NEAR(volume.Irradiance(p, kUp).x, factor * field(p), 1e-5f * factor * field(p));
  }
}

// At a probe there is nothing to blend: what the harmonics' own irradiance says.
TEST(IrradianceVolume, AtAProbeIsTheProbesOwnIrradiance) {
  const LitYard yard;
  IrradianceVolume volume;
  FoldedVolume(yard.probes, yard.basis).Combine(kDay, {}, volume);
  for (const std::size_t p : {0u, 31u, 60u}) {
    if (volume.valid[p] == 0) continue;
    for (const glm::vec3& n : {kUp, -kUp, glm::vec3(0.6f, -0.48f, 0.64f)}) {
      const glm::vec3 expected = IrradianceFromSh(volume.probes[p], n);
      const glm::vec3 got = volume.Irradiance(volume.grid.PositionM(p), n);
      // Positions round too: within 1e-6 of a cell the neighbours have as little weight.
      for (glm::length_t c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], 1e-5f * 1000.0f);
    }
  }
}

// More points than one task holds, and a rest.
TEST(IrradianceVolume, ManyPointsAreAsOneByOne) {
  const LitYard yard;
  IrradianceVolume volume;
  FoldedVolume(yard.probes, yard.basis).Combine(kDay, {}, volume);
  std::vector<glm::vec3> positions, normals;
  for (int i = 0; i < 5000; ++i) {
    const auto t = static_cast<float>(i);
    positions.emplace_back(6.0f * std::sin(0.7f * t), 4.0f * std::cos(1.3f * t), 0.0008f * t);
    normals.push_back(
        glm::normalize(glm::vec3(std::sin(t), std::cos(2.0f * t), std::sin(3.0f * t + 1))));
  }
  std::vector<glm::vec3> together(positions.size()), kept(positions.size());
  IrradianceAt(volume, positions, normals, together);
  VertexIrradiance(volume, positions, normals).Evaluate(volume, kept);
  EXPECT_EQ(together, kept);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    ASSERT_EQ(together[i], volume.Irradiance(positions[i], normals[i])) << i;
  }
}

}  // namespace
}  // namespace pleinair::irradiance_volume_test
