// The recordings' surveys with their sun cut off.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "datasets/sequence.h"
#include "relight/survey/survey.h"
#include "session/sequence_site.h"

namespace pleinair::survey_recorded_test {
namespace {

// What surveys of one map under several limits have in common.
constexpr GatherOptions kRays{.rays_per_receiver = 64};

struct SurveySite {
  explicit SurveySite(const std::filesystem::path& folder)
      : site(LoadSequenceSite(ReadSequence(folder))),
        patches(BuildPatchScene(site.model.mesh, {.patch_size_m = 1.5, .growth_per_m = 0.3})),
        transport(patches, kRays) {}

  SequenceSite site;
  PatchScene patches;
  PatchTransport transport;

  Survey Make(const SurveyMap& map) {
    const std::vector<std::uint8_t> diffuse(patches.PatchCount(), 1);
    for (std::size_t face = 0; face < patches.FaceCount(); ++face) {
      patches.face_albedo_rgb[face] = glm::vec3(0.5f);
    }
    return MakeSurvey(map, transport, {diffuse}, {kRays, kAllBounces, 8, 4}, patches);
  }
};

float BrightestSky(const Survey& survey) {
  float brightest = 0.0f;
  for (const glm::vec3& pixel : survey.light.sky_radiance.pixels) {
    brightest = std::max({brightest, pixel.x, pixel.y, pixel.z});
  }
  return brightest;
}

double MedianRatio(const Survey& clipped, const Survey& whole) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < whole.view.region.pixels.size(); ++i) {
    if (whole.view.albedo_measured.pixels[i] == 0 || whole.view.sun_visibility.pixels[i] < 1.0f) {
      continue;
    }
    ratios.push_back(double{clipped.view.albedo_rgb.pixels[i].y} /
                     double{whole.view.albedo_rgb.pixels[i].y});
  }
  std::nth_element(
      ratios.begin(), ratios.begin() + std::ptrdiff_t(ratios.size() / 2), ratios.end());
  return ratios[ratios.size() / 2];
}

SurveyMap Cut(SurveyMap map, float limit) {
  for (glm::vec3& pixel : map.radiance.pixels) pixel = glm::min(pixel, glm::vec3(limit));
  return map;
}

std::filesystem::path Recording(const char* name) {
  return std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences" / name;
}

// docs/accuracy.md has the figures, of seeds 1 to 5 of the rays. 3 % of the unclipped map's albedo
// is the law for maps with lit and shaded pairs, and what the worst seed is off. The sun is at
// most 4.5 % off, with 0.6 % of noise (standard deviation between seeds), and within one stated
// deviation. That is at most 6.4 %, of the albedo 5.6 %, with 0.1 % of noise.
TEST(RecordedSurvey, ShadowsDetermineTheSunOfACourtyard) {
  const std::filesystem::path folder = Recording("courtyard-clouds");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  SurveySite site(folder);
  const SurveyMap& map = *site.site.model.environment;
  const Survey whole = site.Make(map);
  EXPECT_EQ(whole.light.sun_origin, SunOrigin::kMap);
  // A limit of 10^3 cuts the same pixels as one of 10^4.
  for (const float limit : {1e4f, 4.0f * BrightestSky(whole)}) {
    const Survey clipped = site.Make(Cut(map, limit));
    EXPECT_EQ(clipped.light.sun_origin, SunOrigin::kShadows) << limit;
    const double ratio = MedianRatio(clipped, whole);
    EXPECT_NEAR(ratio, 1.0, 0.03) << limit;
    EXPECT_LT(std::abs(ratio - 1.0), clipped.light.albedo_stddev_rgb.y) << limit;
    const glm::dvec3 sun = clipped.light.sun_irradiance_rgb / whole.light.sun_irradiance_rgb;
    const glm::dvec3 stddev =
        clipped.light.sun_irradiance_stddev_rgb / whole.light.sun_irradiance_rgb;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sun[c], 1.0, 0.051) << limit;
      EXPECT_NEAR(sun[c], 1.0, stddev[c]) << limit;
      EXPECT_LT(stddev[c], 0.065) << limit;
      EXPECT_LT(clipped.light.albedo_stddev_rgb[c], 0.058) << limit;
    }
  }
}

// Its map shows some hundred shaded pixels of one material: too few to be better than a clear sky.
// So neither result has noise of the rays: albedo 6 % off, the sun 6, 7 and 5 %, each to be no
// worse than another 1 %. Its hue is right to 12 %: what the air's haze and ozone may be. The clear
// sky's beam is stated to 60 % of itself, the albedo to what follows from it.
TEST(RecordedSurvey, TheClearSkyCoversASunWithoutShadows) {
  const std::filesystem::path folder = Recording("parking-shadow");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  SurveySite site(folder);
  const SurveyMap& map = *site.site.model.environment;
  const Survey whole = site.Make(map);
  const Survey clipped = site.Make(Cut(map, 1e4f));
  EXPECT_EQ(clipped.light.sun_origin, SunOrigin::kClearSky);
  const double ratio = MedianRatio(clipped, whole);
  EXPECT_NEAR(ratio, 1.0, 0.07);
  EXPECT_LT(std::abs(ratio - 1.0), clipped.light.albedo_stddev_rgb.y);
  const glm::dvec3 sun = clipped.light.sun_irradiance_rgb / whole.light.sun_irradiance_rgb;
  const glm::dvec3 worst(0.07, 0.085, 0.065);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sun[c], 1.0, worst[c]);
    EXPECT_NEAR(sun[c] / sun.y, 1.0, 0.13);
    const double stddev = clipped.light.sun_irradiance_stddev_rgb[c];
    EXPECT_NEAR(stddev, 0.60 * clipped.light.sun_irradiance_rgb[c], 0.01 * stddev);
    EXPECT_LT(clipped.light.albedo_stddev_rgb[c], 0.57);
  }
}

}  // namespace
}  // namespace pleinair::survey_recorded_test
