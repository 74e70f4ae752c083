#include "relight/prepared_scene.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "scene/lat_long.h"
#include "tests/relight/memory_store.h"
#include "tests/relight/solve_sky.h"
#include "tests/relight/survey_test_site.h"

namespace pleinair::prepared_scene_test {
namespace {

// One in which the power is cut while it saves.
class CutStore : public MemoryStore {
 public:
  void Save(std::string_view key, std::string_view bytes) override {
    MemoryStore::Save(key, bytes);
    if (--saves_until_cut == 0) throw std::runtime_error("power cut");
  }

  int saves_until_cut = std::numeric_limits<int>::max();
};

PrepareOptions Quick() {
  PrepareOptions options = KnownSite::Options();
  options.gather.rays_per_receiver = 16;
  options.patches = {.patch_size_m = 2.0, .growth_per_m = 0.5};
  options.survey_receiver_block_px = 8;
  return options;
}

// A map is a map: what it shows does not matter here.
SiteModel Site() {
  RgbImage map = TheKnownSite().sky;
  for (int y = 64; y < 128; ++y) {
    for (int x = 0; x < 256; ++x) map.At(x, y) = glm::vec3(12.0f);
  }
  return TheKnownSite().Model(std::move(map));
}

TEST(PreparedScene, RefusesMoreMemoryThanThereIs) {
  PrepareOptions options = Quick();
  options.memory_limit_bytes = 1000;
  MemoryStore store;
  EXPECT_THROW(PrepareScene(Site(), options, store, {}), std::runtime_error);
  EXPECT_TRUE(store.blobs.empty());
}

void ExpectSame(const PreparedScene& a, const PreparedScene& b) {
  EXPECT_EQ(a.patches.face_albedo_rgb, b.patches.face_albedo_rgb);
  EXPECT_EQ(a.notes, b.notes);
  ASSERT_TRUE(a.survey && b.survey);
  EXPECT_EQ(a.survey->view.albedo_rgb.pixels, b.survey->view.albedo_rgb.pixels);
  EXPECT_EQ(a.survey->view.sun_bounce.pixels, b.survey->view.sun_bounce.pixels);
  EXPECT_EQ(a.survey->light.sky_radiance.pixels, b.survey->light.sky_radiance.pixels);
  EXPECT_EQ(a.survey->light.sun_irradiance_rgb, b.survey->light.sun_irradiance_rgb);
  const auto sky = MakeUniformSkyShape();
  EXPECT_EQ(SolveSky(a.transport, a.patches, *sky, kAllBounces).radiosity,
            SolveSky(b.transport, b.patches, *sky, kAllBounces).radiosity);
  EXPECT_EQ(a.survey->gather->Rays().FromSky(*sky), b.survey->gather->Rays().FromSky(*sky));
  EXPECT_EQ(a.probes.Valid(), b.probes.Valid());
}

TEST(PreparedScene, ComesBackFromTheStoreAsItWas) {
  MemoryStore store;
  std::vector<std::string> stages;
  const auto progress = [&](std::string_view stage, double share) {
    if (share == 0.0) stages.emplace_back(stage);
  };
  const PreparedScene made = PrepareScene(Site(), Quick(), store, progress);
  EXPECT_FALSE(made.from_store);
  EXPECT_EQ(stages.size(), 3u);
  stages.clear();
  const PreparedScene loaded = PrepareScene(Site(), Quick(), store, progress);
  EXPECT_TRUE(loaded.from_store);
  EXPECT_TRUE(stages.empty());
  ExpectSame(made, loaded);
}

TEST(PreparedScene, GoesOnWhereItWasCutOff) {
  CutStore store;
  store.saves_until_cut = 2;
  EXPECT_THROW(PrepareScene(Site(), Quick(), store, {}), std::runtime_error);
  std::vector<std::string> stages;
  PrepareScene(Site(), Quick(), store, [&](std::string_view stage, double share) {
    if (share == 0.0) stages.emplace_back(stage);
  });
  EXPECT_EQ(stages, std::vector<std::string>{"probes"});
}

TEST(PreparedScene, DamagedAndForeignPartsAreRecomputed) {
  MemoryStore store;
  const PreparedScene made = PrepareScene(Site(), Quick(), store, {});
  const auto good = store.blobs;
  ASSERT_EQ(good.size(), 3u);
  for (auto& [key, blob] : store.blobs) blob[blob.size() / 2] ^= 1;
  PreparedScene again = PrepareScene(Site(), Quick(), store, {});
  EXPECT_FALSE(again.from_store);
  ExpectSame(made, again);
  for (auto& [key, blob] : store.blobs) blob.resize(blob.size() / 2);
  EXPECT_FALSE(PrepareScene(Site(), Quick(), store, {}).from_store);
  for (auto& [key, blob] : store.blobs) blob.clear();
  EXPECT_FALSE(PrepareScene(Site(), Quick(), store, {}).from_store);
  // Undamaged parts, each under another's key.
  store.blobs = good;
  auto first = store.blobs.begin();
  std::swap(first->second, std::next(first)->second);
  again = PrepareScene(Site(), Quick(), store, {});
  EXPECT_FALSE(again.from_store);
  ExpectSame(made, again);
  EXPECT_TRUE(PrepareScene(Site(), Quick(), store, {}).from_store) << "and was repaired";
}

TEST(PreparedScene, AnythingThatMattersMakesAnotherKey) {
  MemoryStore store;
  PrepareScene(Site(), Quick(), store, {});
  const auto is_recomputed = [&](const SiteModel& site, const PrepareOptions& options) {
    return !PrepareScene(site, options, store, {}).from_store;
  };
  EXPECT_FALSE(is_recomputed(Site(), Quick()));
  SiteModel site = Site();
  site.environment->radiance.At(3, 100).x += 1e-3f;
  EXPECT_TRUE(is_recomputed(site, Quick()));
  site = Site();
  site.mesh.positions_m[0].x += 1e-3f;
  EXPECT_TRUE(is_recomputed(site, Quick()));
  site = Site();
  site.diffuse_regions = {"ground"};
  EXPECT_TRUE(is_recomputed(site, Quick()));
  PrepareOptions options = Quick();
  options.bounces = 1;
  EXPECT_TRUE(is_recomputed(Site(), options));
  options = Quick();
  options.gather.seed = 2;
  EXPECT_TRUE(is_recomputed(Site(), options));
  options = Quick();
  options.probes.seed = 2;
  EXPECT_TRUE(is_recomputed(Site(), options));
  options = Quick();
  options.survey_map_width = 128;
  EXPECT_TRUE(is_recomputed(Site(), options));
}

// A survey by means over 4 x 4 pixels: the same as by a map that came so, and with nearly the same
// light. What a mean is partly of may not be sampled.
TEST(PreparedScene, SurveysByASmallerMap) {
  SiteModel site = Site();
  site.diffuse_mask.emplace(256, 128, std::uint8_t{255});
  site.diffuse_mask->At(9, 100) = 0;
  PrepareOptions options = Quick();
  options.survey_map_width = 64;
  MemoryStore store;
  const PreparedScene small = PrepareScene(site, options, store, {});
  EXPECT_EQ(small.survey->view.Width(), 64);
  EXPECT_EQ(small.survey->view.Height(), 32);

  SiteModel came_small = site;
  came_small.environment->radiance = DownsampleLatLong(site.environment->radiance, {64, 32});
  came_small.diffuse_mask.emplace(64, 32, std::uint8_t{255});
  came_small.diffuse_mask->At(2, 25) = 0;
  ExpectSame(small, PrepareScene(came_small, Quick(), store, {}));

  const PreparedScene own = PrepareScene(site, Quick(), store, {});
  const double sky = own.survey->light.sky_irradiance_rgb.y;
  EXPECT_NEAR(small.survey->light.sky_irradiance_rgb.y, sky, 0.01 * sky);
}

TEST(PreparedScene, WithoutAMapTheMaterialsAlbedoStands) {
  SiteModel site = Site();
  site.environment.reset();
  site.mesh.materials[0].diffuse_albedo = {0.2f, 0.3f, 0.4f};
  MemoryStore store;
  const PreparedScene prepared = PrepareScene(site, Quick(), store, {});
  EXPECT_FALSE(prepared.survey);
  EXPECT_EQ(prepared.patches.face_albedo_rgb[0], glm::vec3(0.2f, 0.3f, 0.4f));
}

TEST(PreparedSceneHardCases, RefusesOptionsThatMakeNoSenseBeforeAnyWork) {
  const auto refused = [](const auto& spoil) {
    PrepareOptions options = Quick();
    spoil(options);
    MemoryStore store;
    EXPECT_THROW(PrepareScene(Site(), options, store, {}), std::invalid_argument);
    EXPECT_TRUE(store.blobs.empty());
  };
  refused([](PrepareOptions& o) { o.bounces = -2; });
  refused([](PrepareOptions& o) { o.gather.rays_per_receiver = 0; });
  refused([](PrepareOptions& o) { o.probes.rays_per_probe = 0; });
  refused([](PrepareOptions& o) { o.patches.patch_size_m = -1.0; });
  refused([](PrepareOptions& o) { o.survey_receiver_block_px = 0; });
  refused([](PrepareOptions& o) { o.survey_map_width = -64; });
  refused([](PrepareOptions& o) { o.survey_map_width = 100; });
  refused([](PrepareOptions& o) { o.survey_map_width = 512; });
  refused([](PrepareOptions& o) { o.probe_counts.y = 0; });
  refused([](PrepareOptions& o) { o.probe_box.lower_m.x = std::nanf(""); });
}

}  // namespace
}  // namespace pleinair::prepared_scene_test
