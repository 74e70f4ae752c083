// Mirror images against what a mirror must show.
#include "objects/mirror_image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include <tbb/global_control.h>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/objects/object_test_scenes.h"

namespace pleinair::mirror_image_test {
namespace {

constexpr float kInvPi = std::numbers::inv_pi_v<float>;
const glm::vec3 kReflectance{0.8f, 0.6f, 0.4f};

// Level, facing up; (x0, -side) to (x1, side).
Mesh Plate(float x0, float x1, float side, float z, const Material& material) {
  Mesh mesh;
  mesh.positions_m = {{x0, -side, z}, {x1, -side, z}, {x1, side, z}, {x0, side, z}};
  mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_material.assign(2, 0);
  mesh.triangle_group.assign(2, 0);
  mesh.materials = {material};
  mesh.group_names = {"plate"};
  return mesh;
}

Mesh Ball(const glm::vec3& centre_m, float radius_m, const Material& material) {
  constexpr int kRings = 48;
  Mesh mesh;
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int i = 0; i <= 2 * kRings; ++i) {
      const float theta = std::numbers::pi_v<float> * static_cast<float>(ring) / kRings;
      const float phi = std::numbers::pi_v<float> * static_cast<float>(i) / kRings;
      const glm::vec3 normal(
          std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      mesh.positions_m.push_back(centre_m + radius_m * normal);
      mesh.normals.push_back(normal);
    }
  }
  const std::uint32_t row = 2 * kRings + 1;
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    for (std::uint32_t i = 0; i < 2 * kRings; ++i) {
      const std::uint32_t a = ring * row + i;
      mesh.triangles.emplace_back(a, a + row, a + row + 1);
      mesh.triangles.emplace_back(a, a + row + 1, a + 1);
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.materials = {material};
  mesh.group_names = {"ball"};
  return mesh;
}

Material Mirror(float roughness) {
  Material material;
  material.diffuse_albedo = glm::vec3(0.0f);
  material.specular_reflectance = kReflectance;
  material.roughness = roughness;
  return material;
}

// Level, from (-5, 0, height) along +x.
Camera FromBeside(double height_m) {
  Camera camera;
  camera.intrinsics = {64, 64, 150.0, 150.0, 31.5, 31.5, {}};
  camera.camera_from_world = glm::dmat4(0.0,
                                        0.0,
                                        1.0,
                                        0.0,  //
                                        -1.0,
                                        0.0,
                                        0.0,
                                        0.0,  //
                                        0.0,
                                        -1.0,
                                        0.0,
                                        0.0,  //
                                        0.0,
                                        height_m,
                                        5.0,
                                        1.0);  // Columns.
  return camera;
}

struct Radiosities {
  std::vector<glm::vec3> real;
  std::vector<glm::vec3> objects;
};

Radiosities Dark(const PatchScene& real, const PatchScene& objects) {
  return {std::vector<glm::vec3>(real.FaceCount(), glm::vec3(0.0f)),
          std::vector<glm::vec3>(objects.FaceCount(), glm::vec3(0.0f))};
}

// Under one sky shape alone, sun folded as dark.
MirroredLight UnderSky(MirrorImage& image,
                       const SkyShape* sky,
                       const Radiosities& of_sky,
                       const PatchScene& real,
                       const PatchScene& objects) {
  const Radiosities dark = Dark(real, objects);
  image.Fold(0, {nullptr, dark.real, dark.objects, {}, {}}, real, objects);
  image.Fold(1, {sky, of_sky.real, of_sky.objects, {}, {}}, real, objects);
  Lighting lighting;
  lighting.sky = {{"uniform", glm::dvec3(1.0)}};
  MirroredLight light;
  image.Evaluate(lighting, {}, light);
  return light;
}

// Seen from above, a level mirror shows the zenith: a uniform sky's 1 / pi, times its reflectance
// at normal incidence. Schlick's term at 6 deg, the picture's corner, is below 1e-10.
TEST(MirrorImage, ALevelMirrorShowsTheSky) {
  const PatchScene objects = PatchesOf(Plate(-0.5f, 0.5f, 0.5f, 0.0f, Mirror(0.0f)));
  const PatchScene real = PatchesOf(Mesh{});
  const ObjectView view = SeeObjects(objects, FromAbove());
  MirrorImage image(real, objects, view);
  ASSERT_FALSE(image.Empty());
  const auto sky = MakeUniformSkyShape();
  const MirroredLight light = UnderSky(image, sky.get(), Dark(real, objects), real, objects);
  int inside = 0;
  for (int y = 2; y + 2 < light.radiance.height; ++y) {
    for (int x = 2; x + 2 < light.radiance.width; ++x) {
      ++inside;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(light.radiance.At(x, y)[c], kReflectance[c] * kInvPi, 1e-5);
      }
    }
  }
  EXPECT_GT(inside, 28 * 28);
}

// A ceiling 20 m up, over x > 0: from the eye 10 m up the mirror's point x shows the ceiling at 3
// x, and what is seen of it is what it looks like from the mirror, not from the eye.
TEST(MirrorImage, ShowsNearSurfacesFromTheMirrorsOwnPlace) {
  const PatchScene objects = PatchesOf(Plate(-0.9f, 0.9f, 0.9f, 0.0f, Mirror(0.0f)));
  const PatchScene real = PatchesOf(Plate(0.3f, 50.0f, 50.0f, 20.0f, Material{}));
  const ObjectView view = SeeObjects(objects, FromAbove());
  MirrorImage image(real, objects, view, {}, {.rays_per_place = 0});  // The plate hides some.
  Radiosities radiosities = Dark(real, objects);
  for (std::size_t face = 1; face < real.FaceCount(); face += 2) {
    radiosities.real[face] = glm::vec3(3.0f);  // Its underside.
  }
  const MirroredLight light = UnderSky(image, nullptr, radiosities, real, objects);
  const float whole = kReflectance.g * 3.0f * kInvPi;
  for (int x = 2; x + 2 < light.radiance.width; ++x) {
    // What of the pixel lies past the ceiling's edge, at 34.7 px; 32 places in it.
    const float share = std::clamp(static_cast<float>(light.x_px + x) + 0.5f - 34.7f, 0.0f, 1.0f);
    const float tolerance = share > 0.0f && share < 1.0f ? 0.04f * whole : 1e-4f;
    EXPECT_NEAR(light.radiance.At(x, 20).g, share * whole, tolerance) << "x " << x;
  }
}

// Light of one strength from everywhere comes back as the surface's reflectance, whatever its
// roughness: with k = 1 all of it, but for what the facets' masking takes from a single reflection,
// less than 5 % at alpha 0.09.
TEST(MirrorImage, AFurnaceComesBackAsTheReflectance) {
  for (const float roughness : {0.0f, 0.1f, 0.3f}) {
    Material white = Mirror(roughness);
    white.specular_reflectance = glm::vec3(1.0f);
    const PatchScene objects = PatchesOf(Ball({0.0f, 0.0f, 1.0f}, 0.8f, white));
    const PatchScene real = PatchesOf(Plate(-5000.0f, 5000.0f, 5000.0f, 0.0f, Material{}), 1.0f);
    const ObjectView view = SeeObjects(objects, FromBeside(1.0));
    MirrorImage image(real, objects, view);
    const auto sky = MakeUniformSkyShape();
    Radiosities ones = Dark(real, objects);
    std::fill(ones.real.begin(), ones.real.end(), glm::vec3(1.0f));
    std::fill(ones.objects.begin(), ones.objects.end(), glm::vec3(1.0f));
    const MirroredLight light = UnderSky(image, sky.get(), ones, real, objects);
    std::vector<float> seen;
    for (const glm::vec3& pixel : light.radiance.pixels) {
      if (pixel.g > 0.0f) seen.push_back(pixel.g / kInvPi);
    }
    ASSERT_GT(seen.size(), 1500u);
    std::sort(seen.begin(), seen.end());
    EXPECT_LE(seen.back(), 1.0f + 1e-4f);
    EXPECT_GT(seen[seen.size() / 2], 0.95f) << "roughness " << roughness;
    EXPECT_GT(seen[seen.size() / 10], 0.9f) << "roughness " << roughness;
  }
}

// The ground around a ball is lit all over but for the ball's own shadow: in the mirror both are
// seen, whatever its patches say, with nothing between.
TEST(MirrorImage, ShowsTheObjectsOwnShadow) {
  const PatchScene objects = PatchesOf(Ball({0.0f, 0.0f, 1.0f}, 0.8f, Mirror(0.0f)));
  const PatchScene real = PatchesOf(Plate(-500.0f, 500.0f, 500.0f, 0.0f, Material{}));
  const ObjectView view = SeeObjects(objects, FromBeside(1.0));
  MirrorImage image(real, objects, view, {}, {.rays_per_pixel = 1, .rays_per_place = 0});
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.6, 0.0, 1.0));  // Shadow before the ball.
  const auto cosine = static_cast<float>(to_sun.z);
  Radiosities lit = Dark(real, objects);
  for (std::size_t face = 0; face < real.FaceCount(); face += 2) {
    lit.real[face] = glm::vec3(0.5f * cosine);
  }
  const std::vector<glm::vec3> direct(real.FaceCount(), glm::vec3(cosine));
  image.Fold(0, {nullptr, lit.real, lit.objects, direct, {to_sun, {}, 0.0}}, real, objects);
  Lighting lighting;
  lighting.sun.irradiance_rgb = glm::dvec3(1.0);
  MirroredLight light;
  image.Evaluate(lighting, {}, light);
  int bright = 0;
  int dark = 0;
  // Below its equator, away from the rim, where Fresnel's term stays below 0.2 %.
  for (int y = 0; y < light.radiance.height; ++y) {
    const double v = (light.y_px + y - 31.5) / 24.0;
    for (int x = 0; x < light.radiance.width; ++x) {
      const double u = (light.x_px + x - 31.5) / 24.0;
      if (v < 0.3 || u * u + v * v > 0.36) continue;
      const float value = light.radiance.At(x, y).g;
      const float whole = kReflectance.g * 0.5f * cosine * kInvPi;
      if (value == 0.0f) {
        ++dark;
      } else {
        ++bright;
        EXPECT_NEAR(value / whole, 1.0, 2e-3);
      }
    }
  }
  EXPECT_GT(bright, 20);
  EXPECT_GT(dark, 20);
}

// Where a ball stands, it hides the sky from the ground.
TEST(MirrorImage, TheGroundBesideAnObjectIsDarkerUnderTheSky) {
  const PatchScene objects = PatchesOf(Ball({0.0f, 0.0f, 0.8f}, 0.8f, Mirror(0.0f)));
  const PatchScene real = PatchesOf(Plate(-500.0f, 500.0f, 500.0f, 0.0f, Material{}));
  const ObjectView view = SeeObjects(objects, FromBeside(0.8));
  MirrorImage image(real, objects, view);
  const auto sky = MakeUniformSkyShape();
  Radiosities under_sky = Dark(real, objects);
  for (std::size_t face = 0; face < real.FaceCount(); face += 2) {
    under_sky.real[face] = glm::vec3(0.5f);
  }
  const MirroredLight light = UnderSky(image, sky.get(), under_sky, real, objects);
  const int x = 31 - light.x_px;
  const float far = light.radiance.At(x, 36 - light.y_px).g;
  const float near = light.radiance.At(x, 52 - light.y_px).g;
  EXPECT_GT(far, 0.8f * 0.6f * 0.5f * kInvPi);
  EXPECT_LT(near, 0.6f * far);
}

TEST(MirrorImage, DoesNotDependOnThreads) {
  const PatchScene objects = PatchesOf(Ball({0.0f, 0.0f, 1.0f}, 0.8f, Mirror(0.2f)));
  const PatchScene real = PatchesOf(Plate(-500.0f, 500.0f, 500.0f, 0.0f, Material{}));
  const ObjectView view = SeeObjects(objects, FromBeside(1.0));
  const auto sky = MakeUniformSkyShape();
  Radiosities lit = Dark(real, objects);
  std::fill(lit.real.begin(), lit.real.end(), glm::vec3(0.3f));
  const auto make = [&] {
    MirrorImage image(real, objects, view);
    return UnderSky(image, sky.get(), lit, real, objects);
  };
  const MirroredLight two = make();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(make().radiance.pixels, two.radiance.pixels);
}

TEST(MirrorImageHardCases, WithoutGlossInViewThereIsNone) {
  const PatchScene matt = PatchesOf(Plate(-0.5f, 0.5f, 0.5f, 0.0f, Material{}));
  const PatchScene real = PatchesOf(Mesh{});
  EXPECT_TRUE(MirrorImage(real, matt, SeeObjects(matt, FromAbove())).Empty());
  const PatchScene behind = PatchesOf(Plate(-0.5f, 0.5f, 0.5f, 20.0f, Mirror(0.0f)));
  MirrorImage image(real, behind, SeeObjects(behind, FromAbove()));
  EXPECT_TRUE(image.Empty());
  MirroredLight light;
  image.Evaluate(Lighting{}, {}, light);
  EXPECT_TRUE(light.radiance.Empty());
}

// Shading normals that are zero, or point away, and the roughest surface: finite, not negative.
TEST(MirrorImageHardCases, BadNormalsAndFullRoughnessStayFinite) {
  Mesh ball = Ball({0.0f, 0.0f, 1.0f}, 0.8f, Mirror(1.0f));
  for (std::size_t v = 0; v < ball.normals.size(); v += 3) ball.normals[v] = glm::vec3(0.0f);
  for (std::size_t v = 1; v < ball.normals.size(); v += 3) ball.normals[v] = -ball.normals[v];
  const PatchScene objects = PatchesOf(ball);
  const PatchScene real = PatchesOf(Plate(-500.0f, 500.0f, 500.0f, 0.0f, Material{}));
  MirrorImage image(real, objects, SeeObjects(objects, FromBeside(1.0)));
  const auto sky = MakeUniformSkyShape();
  const MirroredLight light = UnderSky(image, sky.get(), Dark(real, objects), real, objects);
  for (const glm::vec3& pixel : light.radiance.pixels) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(pixel[c]));
      ASSERT_GE(pixel[c], 0.0f);
    }
  }
}

TEST(MirrorImageHardCases, RefusesAnotherScenesLight) {
  const PatchScene objects = PatchesOf(Plate(-0.5f, 0.5f, 0.5f, 0.0f, Mirror(0.0f)));
  const PatchScene real = PatchesOf(Plate(-5.0f, 5.0f, 5.0f, -1.0f, Material{}));
  const ObjectView view = SeeObjects(objects, FromAbove());
  MirrorImage image(real, objects, view);
  const std::vector<glm::vec3> wrong(3);
  const std::vector<glm::vec3> right(4);
  EXPECT_THROW(image.Fold(0, {nullptr, wrong, right, {}, {}}, real, objects),
               std::invalid_argument);
  EXPECT_THROW(image.Fold(0, {nullptr, right, right, wrong, {}}, real, objects),
               std::invalid_argument);
  MirroredLight light;
  EXPECT_THROW(image.Evaluate(Lighting{}, {}, light), std::invalid_argument) << "nothing is folded";
  image.Fold(0, {nullptr, right, right, right, {}}, real, objects);
  const std::vector<std::uint8_t> one_too_many(image.SunlitPixels().size() + 1, 0);
  EXPECT_THROW(image.Evaluate(Lighting{}, one_too_many, light), std::invalid_argument);
  EXPECT_THROW(MirrorImage(real, objects, view, {}, {.rays_per_pixel = 0}), std::invalid_argument);
  EXPECT_THROW(MirrorImage(real, objects, view, {}, {.rays_per_place = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::mirror_image_test
