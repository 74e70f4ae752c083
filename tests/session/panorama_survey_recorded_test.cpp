// Real HDR panoramas as surveys, over a plane of ground: made into sequences and run.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/sun_state.h"
#include "relight/surface_view_builder.h"
#include "relight/survey/survey_maps.h"
#include "scene/angle_between.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "session/sequence_site.h"
#include "sunmodel/time_text.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::panorama_survey_recorded_test {
namespace {

namespace fs = std::filesystem;

const fs::path kPanoramas = fs::path(PLEINAIR_SHARED_DIR) / "data/hdr_panoramas";

double Mean(const glm::dvec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0; }

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kEyeHeightM = 1.6;

LatLongSize SizeOf(const RgbImage& map) { return {map.width, map.height}; }

glm::dvec3 PixelDirection(const RgbImage& map, int x, int y) {
  return DirectionFromLatLong({x + 0.5, y + 0.5}, SizeOf(map));
}

// The brightest pixel above the horizon, and the centroid of what is above a tenth of it within
// 1 deg.
struct BrightestSpot {
  glm::dvec3 pixel{0.0, 0.0, 1.0};
  glm::dvec3 centroid{0.0, 0.0, 1.0};
};

BrightestSpot BrightestOf(const RgbImage& map) {
  double peak = 0.0;
  BrightestSpot spot;
  for (int y = 0; y < map.height / 2; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double value = Mean(glm::dvec3(map.At(x, y)));
      if (value <= peak) continue;
      peak = value;
      spot.pixel = PixelDirection(map, x, y);
    }
  }
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height / 2; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 there = PixelDirection(map, x, y);
      const double value = Mean(glm::dvec3(map.At(x, y)));
      if (AngleBetweenRad(there, spot.pixel) < 1.0 * kDeg && value > 0.1 * peak) {
        sum += value * LatLongPixelSolidAngleSr(y, SizeOf(map)) * there;
      }
    }
  }
  spot.centroid = glm::normalize(sum);
  return spot;
}

// A camera in the panorama's place that looks down on the ground, away from the sun.
Camera LookingDown(const glm::dvec3& sun) {
  Camera camera;
  camera.intrinsics = {.width_px = 160,
                       .height_px = 120,
                       .fx_px = 110.0,
                       .fy_px = 110.0,
                       .cx_px = 79.5,
                       .cy_px = 59.5};
  const glm::dvec3 away = -glm::normalize(glm::dvec3(sun.x, sun.y, 0.0));
  const glm::dvec3 forward = glm::normalize(away + glm::dvec3(0.0, 0.0, -0.8));
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 0.0, 1.0)));
  const glm::dvec3 down = glm::cross(forward, right);
  const glm::dvec3 position(0.0, 0.0, kEyeHeightM);
  const glm::dmat3 world_from_camera(right, down, forward);
  const glm::dmat3 camera_from_world = glm::transpose(world_from_camera);
  camera.camera_from_world = glm::dmat4(camera_from_world);
  camera.camera_from_world[3] = glm::dvec4(-(camera_from_world * position), 1.0);
  return camera;
}

// The picture that it would take: the map's own pixels.
RgbImage CutOut(const RgbImage& map, const Camera& camera) {
  const CameraIntrinsics& k = camera.intrinsics;
  RgbImage picture(k.width_px, k.height_px);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const glm::dvec3 ray =
          world_from_camera * glm::dvec3((x - k.cx_px) / k.fx_px, (y - k.cy_px) / k.fy_px, 1.0);
      const glm::ivec2 pixel = LatLongPixelFromDirection(ray, SizeOf(map));
      picture.At(x, y) = map.At(pixel.x, pixel.y);
    }
  }
  return picture;
}

constexpr float kNotCut = std::numeric_limits<float>::infinity();

// A sequence of one frame, on disc, of a map whose values are cut at `limit`. The sun is stated as
// the brightest pixel: no place and time say better.
class PanoramaSequence {
 public:
  PanoramaSequence(const std::string& name, float limit) {
    map_ = ReadRadianceImage(kPanoramas / (name + ".hdr"));
    brightest_ = BrightestOf(map_);
    for (glm::vec3& pixel : map_.pixels) pixel = glm::min(pixel, glm::vec3(limit));
    WriteHdr(folder_.Path() / "environment.hdr", map_);
    std::ofstream(folder_.Path() / "ground.obj")
        << "o ground\nv -40 -40 0\nv 40 -40 0\nv 40 40 0\nv -40 40 0\nf 1 2 3 4\n";
    Sequence sequence;
    sequence.folder = folder_.Path();
    sequence.name = name;
    sequence.scene_mesh = "ground.obj";
    const Camera camera = LookingDown(brightest_.pixel);
    sequence.intrinsics = camera.intrinsics;
    sequence.camera_from_world = camera.camera_from_world;
    sequence.environment = EnvironmentEntry{.image = "environment.hdr",
                                            .position_m = {0.0, 0.0, kEyeHeightM},
                                            .time = ParseUtcTime("2020-06-21T10:00:00Z"),
                                            .sun_direction_enu = brightest_.pixel};
    FrameEntry frame;
    frame.image = "frame.exr";
    frame.time = sequence.environment->time;
    sequence.frames.push_back(frame);
    WriteExr(folder_.Path() / "frame.exr", CutOut(map_, camera), ExrPrecision::kFloat);
    WriteSequence(sequence, folder_.Path());
  }

  const fs::path& Folder() const { return folder_.Path(); }
  const RgbImage& Map() const { return map_; }
  const BrightestSpot& Brightest() const { return brightest_; }

 private:
  TemporaryFolder folder_;
  RgbImage map_;
  BrightestSpot brightest_;
};

PreparedScene PrepareCoarsely(const SequenceSite& site) {
  KeepsNothing store;
  PrepareOptions options = PrepareOptionsFor(site);
  options.patches.patch_size_m = 4.0;
  options.patches.growth_per_m = 0.5;
  options.gather.rays_per_receiver = 64;
  options.survey_receiver_block_px = 16;
  options.probe_counts = {2, 2, 2};
  options.probes.rays_per_probe = 16;
  return PrepareScene(site.model, options, store, {});
}

// The brightest sky within 5 deg of the sun over the median of the ring outside, up to 8 deg; mean
// of RGB.
double BrightestLeftOverRing(const SurveyLight& light) {
  const RgbImage& sky = light.sky_radiance;
  std::vector<double> ring;
  double brightest = 0.0;
  for (int y = 0; y < sky.height / 2; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const double angle = AngleBetweenRad(PixelDirection(sky, x, y), light.sun_direction_enu);
      const double value = Mean(glm::dvec3(sky.At(x, y)));
      if (angle < 5.0 * kDeg) {
        brightest = std::max(brightest, value);
      } else if (angle < 8.0 * kDeg) {
        ring.push_back(value);
      }
    }
  }
  std::nth_element(ring.begin(), ring.begin() + std::ptrdiff_t(ring.size() / 2), ring.end());
  return brightest / ring[ring.size() / 2];
}

// Median over the ground of |relit / seen - 1|, and the share of pixels beyond 10 %.
struct Difference {
  double median = 0.0;
  double beyond_share = 0.0;
};

Difference Compare(const std::vector<double>& ratios) {
  std::vector<double> off;
  int beyond = 0;
  for (const double ratio : ratios) {
    off.push_back(std::abs(ratio - 1.0));
    beyond += off.back() > 0.10 ? 1 : 0;
  }
  std::nth_element(off.begin(), off.begin() + std::ptrdiff_t(off.size() / 2), off.end());
  return {off[off.size() / 2], double(beyond) / double(off.size())};
}

// Share of the ground's pixels that are found in shade that the mesh does not cast.
double UnmodelledShadeShare(const PreparedScene& scene) {
  const Survey& survey = *scene.survey;
  int ground = 0;
  int in_shade = 0;
  for (std::size_t i = 0; i < survey.view.region.pixels.size(); ++i) {
    if (survey.view.region.pixels[i] != 0) continue;
    ++ground;
    in_shade += survey.unmodelled_shade.pixels[i] != 0 ? 1 : 0;
  }
  return static_cast<double>(in_shade) / ground;
}

// Shade that the mesh does not cast is no part of what the model gives back, but of the ground.
Difference RelitMap(const PreparedScene& scene, const RgbImage& map) {
  const SurveyMaps maps = MakeSurveyMaps(*scene.survey);
  const SurfaceView& view = scene.survey->view;
  std::vector<double> ratios;
  int in_shade = 0;
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    if (view.region.pixels[i] != 0) continue;
    if (scene.survey->unmodelled_shade.pixels[i] != 0) {
      ++in_shade;
      continue;
    }
    ratios.push_back(Mean(glm::dvec3(maps.relit.pixels[i])) / Mean(glm::dvec3(map.pixels[i])));
  }
  Difference difference = Compare(ratios);
  const auto compared = static_cast<double>(ratios.size());
  difference.beyond_share *= compared / (compared + in_shade);
  return difference;
}

// The model has the sun in shade that the mesh does not cast; the picture has not. The blur of the
// shade's edge in the map is a pixel wider in a frame.
bool IsInUnmodelledShade(const glm::vec3& position_m, const Survey& survey) {
  const LatLongSize size{survey.view.Width(), survey.view.Height()};
  const glm::ivec2 at = LatLongPixelFromDirection(glm::dvec3(position_m) - survey.position_m, size);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = (at.x + dx + size.width) % size.width;
      const int y = std::clamp(at.y + dy, 0, size.height - 1);
      if (survey.unmodelled_shade.At(x, y) != 0) return true;
    }
  }
  return false;
}

struct FrameLight {
  LightingEstimate estimate;
  Difference relit;  // The frame's ground under the light found.
};

FrameLight EstimateFrame(const Sequence& sequence, const PreparedScene& scene) {
  const Frame frame = MakeRecordedFrameSource(sequence, FrameKind::kLinear)->Next()->value();
  const SunState sun = SunOfFrame(sequence.site, frame);
  const auto source = MakeOutdoorLightingSource({});
  const auto basis = source->BasisFor(frame, sun).value();
  SurfaceViewBuilder builder(scene, {});
  const SurfaceView& view =
      builder.Update(frame.camera, sun.direction_enu, sun.angular_radius_rad, basis, {});
  const ScaledClearSky clear_sky(sequence.site, &scene.survey->light);
  FrameLight found;
  found.estimate =
      source
          ->Estimate({frame,
                      view,
                      sun,
                      clear_sky.At(sun.direction_enu),
                      std::nullopt,
                      scene.albedo_stddev_rgb,
                      0.0,
                      SurveyedLight{scene.survey_time.value(),
                                    scene.survey->light.sun_irradiance_rgb,
                                    scene.survey->light.sun_irradiance_stddev_rgb,
                                    scene.survey->light.sky_irradiance_rgb,
                                    clear_sky.At(scene.survey->light.sun_direction_enu)}})
          .value();
  const Lighting& light = found.estimate.lighting;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
    if (view.region.pixels[i] != 0 ||
        IsInUnmodelledShade(view.position_world_m.pixels[i], *scene.survey))
      continue;
    glm::dvec3 irradiance =
        light.sun.irradiance_rgb * glm::dvec3(SunResponse(view, i, sun.direction_enu));
    for (std::size_t k = 0; k < light.sky.size(); ++k) {
      irradiance += light.sky[k].irradiance_rgb * glm::dvec3(view.sky_response[k].pixels[i]);
    }
    const glm::dvec3 relit = glm::dvec3(view.albedo_rgb.pixels[i]) / std::numbers::pi * irradiance;
    ratios.push_back(Mean(relit) / Mean(glm::dvec3(frame.radiance.pixels[i])));
  }
  found.relit = Compare(ratios);
  return found;
}

struct SurveyedPanorama {
  PanoramaSequence files;
  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;

  explicit SurveyedPanorama(const std::string& name, float limit = kNotCut)
      : files(name, limit),
        sequence(ReadSequence(files.Folder())),
        site(LoadSequenceSite(sequence)),
        scene(PrepareCoarsely(site)) {}
  const SurveyLight& Light() const { return scene.survey->light; }
};

// A panorama, and how far its frame's ground may be off under the light that is found in it. The
// frame's pixels are the map's nearest, their albedo is blended between the map's: paving hardly
// has scatter of its own, the dry grass of the last two has much.
struct GroundBound {
  const char* name;
  double median;
  double beyond_share;
  // Of the share of the ground that is found in shade. Nothing is in kloofendal and kloppenheim;
  // the long shadows of spruit_sunrise are not found.
  double least_shade_share = 0.0;
  double most_shade_share = 0.0;
};

class SunnyPanorama : public testing::TestWithParam<GroundBound> {
 protected:
  void SetUp() override {
    if (!fs::exists(kPanoramas)) GTEST_SKIP() << kPanoramas << " is absent";
  }
};

// docs/accuracy.md has the figures. Each tolerance is the figure and a tenth of it, as rays and
// samples are drawn with one seed.
TEST_P(SunnyPanorama, IsSplitIntoSunAndSkyAndGivesItsGroundBack) {
  const SurveyedPanorama panorama(GetParam().name);
  const SurveyLight& light = panorama.Light();
  EXPECT_EQ(light.sun_origin, SunOrigin::kMap);
  // 0.18 deg, half of a pixel.
  EXPECT_LT(AngleBetweenRad(light.sun_direction_enu, panorama.files.Brightest().centroid),
            0.20 * kDeg);
  EXPECT_LE(BrightestLeftOverRing(light), 2.0);  // 1.81.
  // A disc and its glare outshine any sky.
  EXPECT_GT(Mean(light.sun_irradiance_rgb), Mean(light.sky_irradiance_rgb));
  EXPECT_LT(Mean(light.sun_irradiance_stddev_rgb),
            0.04 * Mean(light.sun_irradiance_rgb));  // 3.6 %.

  const double shade_share = UnmodelledShadeShare(panorama.scene);
  EXPECT_GE(shade_share, GetParam().least_shade_share);
  EXPECT_LE(shade_share, GetParam().most_shade_share);
  // Some of the ground's own pixels are too bright for any albedo: 0.5 %.
  EXPECT_LT(RelitMap(panorama.scene, panorama.files.Map()).beyond_share, 0.0055);
  const FrameLight frame = EstimateFrame(panorama.sequence, panorama.scene);
  EXPECT_LT(frame.relit.median, GetParam().median);
  EXPECT_LT(frame.relit.beyond_share, GetParam().beyond_share);
  // A plane of ground cannot separate sun and sky; the survey, taken at that moment, can: to 4.9 %.
  EXPECT_FALSE(frame.estimate.sun_observable);
  EXPECT_NEAR(Mean(frame.estimate.lighting.sun.irradiance_rgb) / Mean(light.sun_irradiance_rgb),
              1.0,
              0.054);
}

// A plane of ground has no shadows, so that the sun is the one that goes with the sky between its
// clouds. It is 1.35, 1.45 and 0.49 times the disc's, where that of the whole sky, clouds included,
// would be 1.5, 2.5 and 0.52 times.
TEST(CutPanorama, HasTheSunThatGoesWithTheSkyBetweenItsClouds) {
  if (!fs::exists(kPanoramas)) GTEST_SKIP() << kPanoramas << " is absent";
  struct Bound {
    const char* name;
    double log_error;
  };
  // At sunrise, haze dims the beam by its depth seven times: within two stated deviations.
  for (const auto& [name, log_error] : {Bound{"kloppenheim_05_1k", 0.35},
                                        Bound{"kloofendal_48d_partly_cloudy_1k", 0.42},
                                        Bound{"spruit_sunrise_1k", 0.80}}) {
    const double whole = Mean(SurveyedPanorama(name).Light().sun_irradiance_rgb);
    const SurveyedPanorama cut(name, 30.0f);
    EXPECT_EQ(cut.Light().sun_origin, SunOrigin::kClearSky) << name;
    EXPECT_LT(std::abs(std::log(Mean(cut.Light().sun_irradiance_rgb) / whole)), log_error) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Recorded,
    SunnyPanorama,
    testing::Values(GroundBound{"modern_buildings_2_1k", 0.028, 0.056, 0.12, 0.17},
                    GroundBound{"kloofendal_48d_partly_cloudy_1k", 0.013, 0.001},
                    GroundBound{"kloppenheim_05_1k", 0.066, 0.33},
                    GroundBound{"spruit_sunrise_1k", 0.080, 0.42}),
    [](const auto& instance) { return std::string(instance.param.name); });

// An overcast square, a low sun behind clouds, two rooms.
class SunlessPanorama : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!fs::exists(kPanoramas)) GTEST_SKIP() << kPanoramas << " is absent";
  }
};

TEST_P(SunlessPanorama, HasNoSunInvented) {
  const SurveyedPanorama panorama(GetParam());
  const SurveyLight& light = panorama.Light();
  EXPECT_EQ(light.sun_origin, SunOrigin::kMap);
  // A lamp has some per cent of a room's light.
  EXPECT_LT(Mean(light.sun_irradiance_rgb), 0.08 * Mean(light.sky_irradiance_rgb));
  EXPECT_EQ(UnmodelledShadeShare(panorama.scene), 0.0);
  EXPECT_LT(RelitMap(panorama.scene, panorama.files.Map()).median, 0.10);
  // Furniture is no plane of ground: what it shows is explained by a sun in part, and rooms have
  // lamps.
  const FrameLight frame = EstimateFrame(panorama.sequence, panorama.scene);
  const Lighting& found = frame.estimate.lighting;
  EXPECT_FALSE(frame.estimate.sun_observable);
  EXPECT_LT(Mean(found.sun.irradiance_rgb) * found.sun.direction_enu.z,
            0.15 * Mean(found.SkyIrradianceRgb()));
}

INSTANTIATE_TEST_SUITE_P(Recorded,
                         SunlessPanorama,
                         testing::Values("potsdamer_platz_1k",
                                         "blouberg_sunrise_2_1k",
                                         "lebombo_1k",
                                         "st_fagans_interior_1k"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace pleinair::panorama_survey_recorded_test
