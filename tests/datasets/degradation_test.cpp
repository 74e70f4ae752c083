// Imperfections of a recording: each does what its definition says, and nothing else.
#include "datasets/degradation.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/statistics.h"
#include "datasets/truth.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "scene/srgb.h"
#include "sunmodel/angles.h"

namespace pleinair::degradation_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kCourtyard = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";
constexpr int kWidth = 160;
constexpr int kHeight = 120;
const glm::vec3 kColour(0.3f, 0.2f, 0.1f);
constexpr std::uint64_t kSeed = 3;

RgbImage Flat(const glm::vec3& rgb) { return RgbImage(kWidth, kHeight, rgb); }

// Signal in [0, 1] that an sRGB camera would have had, mean over a part of the picture.
glm::dvec3 MeanSignal(const Rgb8Image& codes, int left, int top, int right, int bottom) {
  glm::dvec3 sum(0.0);
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += LinearFromSrgb(codes.At(x, y)[c] / 255.0);
    }
  }
  return sum / double((right - left) * (bottom - top));
}

glm::dvec3 MeanSignal(const Rgb8Image& codes) {
  return MeanSignal(codes, 0, 0, codes.width, codes.height);
}

// Tolerance of a flat picture's mean: 4 deviations of its noise (0.005 a pixel at most,
// over 19200 of them), and the rounding to codes, which that noise spreads over several.
constexpr double kMeanTolerance = 4.0 * 0.005 / 138.0 + 1e-4;

void ExpectNear(const glm::dvec3& is, const glm::dvec3& expected, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(is[c], expected[c], tolerance) << "channel " << c;
}

glm::dvec3 MeanOf(const Imperfections& sizes, const glm::vec3& rgb = kColour) {
  return MeanSignal(Degradation(sizes, kSeed).Picture(Flat(rgb), 1.0, 0));
}

TEST(Degradation, AnIdealCameraAddsItsNoiseAlone) {
  const Rgb8Image codes = Degradation({}, kSeed).Picture(Flat(2.0f * kColour), 0.5, 0);
  ExpectNear(MeanSignal(codes), glm::dvec3(kColour), kMeanTolerance);
  double squares = 0.0;
  for (const glm::u8vec3& code : codes.pixels) {
    squares += std::pow(LinearFromSrgb(code.x / 255.0) - kColour.x, 2.0);
  }
  const double expected = SignalNoise(ResponseCurve::Srgb()).Variance(0, kColour.x);
  // A variance over n values has a relative deviation of sqrt(2 / n).
  const double n = kWidth * kHeight;
  EXPECT_NEAR(squares / n, expected, 4.0 * std::sqrt(2.0 / n) * expected);
}

TEST(Degradation, GainsAreOfRedAndBlueOverGreen) {
  Imperfections sizes;
  sizes.gain_log_stddev = 0.1;
  const glm::dvec3 once = MeanOf(sizes) / glm::dvec3(kColour);
  EXPECT_NEAR(once.y, 1.0, kMeanTolerance / kColour.y);
  EXPECT_GT(std::abs(std::log(once.x)), 0.01);
  EXPECT_GT(std::abs(std::log(once.z)), 0.01);
  sizes.gain_log_stddev = 0.2;
  const glm::dvec3 twice = MeanOf(sizes) / glm::dvec3(kColour);
  // The same draw, scaled.
  for (const int c : {0, 2}) {
    EXPECT_NEAR(std::log(twice[c]), 2.0 * std::log(once[c]), 3.0 * kMeanTolerance / kColour[c]);
  }
}

TEST(Degradation, VeilIsAShareOfTheMeanPicture) {
  Imperfections sizes;
  sizes.veil_share = 0.05;
  RgbImage half = Flat(glm::vec3(0.0f));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) half.At(x, y) = kColour;
  }
  const Rgb8Image codes = Degradation(sizes, kSeed).Picture(half, 1.0, 0);
  const glm::dvec3 veil = 0.05 * 0.5 * glm::dvec3(kColour);
  const double tolerance = 2.0 * kMeanTolerance;  // Over half of the pixels.
  ExpectNear(MeanSignal(codes, 0, 0, kWidth / 2, kHeight), glm::dvec3(kColour) + veil, tolerance);
  ExpectNear(MeanSignal(codes, kWidth / 2, 0, kWidth, kHeight), veil, 5e-4);
}

TEST(Degradation, CornersLoseLightAndTheCentreDoesNot) {
  Imperfections sizes;
  sizes.vignette_share = 0.4;
  const Rgb8Image codes = Degradation(sizes, kSeed).Picture(Flat(kColour), 1.0, 0);
  // 8 x 8 pixels: 4 deviations of their mean's noise.
  const double tolerance = 4.0 * 0.005 / 8.0;
  ExpectNear(MeanSignal(codes, 76, 56, 84, 64), glm::dvec3(kColour), tolerance);
  // Their middle is 3.5 pixels from the corner's along each side.
  const double far = (std::pow(79.5 - 3.5, 2.0) + std::pow(59.5 - 3.5, 2.0)) / (80 * 80 + 60 * 60);
  ExpectNear(
      MeanSignal(codes, 0, 0, 8, 8), (1.0 - 0.4 * far) * glm::dvec3(kColour), tolerance + 1e-3);
}

TEST(Degradation, SaturationLeavesGreyAloneAndSpreadsColours) {
  Imperfections sizes;
  sizes.saturation = 0.3;
  ExpectNear(MeanOf(sizes, glm::vec3(0.25f)), glm::dvec3(0.25), kMeanTolerance);
  const glm::dvec3 colour = MeanOf(sizes);
  EXPECT_NEAR(colour.y, kColour.y, kMeanTolerance) << "is its grey";
  EXPECT_GT(colour.x, kColour.x + 0.005);
  EXPECT_NEAR(colour.x - colour.y, colour.y - colour.z, 3.0 * kMeanTolerance);
}

TEST(Degradation, TheCurveIsAGammaOnTopOfSrgb) {
  Imperfections sizes;
  sizes.curve_log_stddev = 0.2;
  const auto gamma = [&](float level) {
    const glm::dvec3 mean = MeanOf(sizes, glm::vec3(level));
    return std::log(SrgbFromLinear(mean.x)) / std::log(SrgbFromLinear(level));
  };
  EXPECT_GT(std::abs(std::log(gamma(0.2f))), 0.01);
  EXPECT_NEAR(gamma(0.2f), gamma(0.6f), 0.005);
}

TEST(Degradation, SharpeningOvershootsAtEdgesAlone) {
  Imperfections sizes;
  sizes.sharpening = 0.5;
  ExpectNear(MeanOf(sizes), glm::dvec3(kColour), 2.0 * kMeanTolerance);
  RgbImage step = Flat(glm::vec3(0.1f));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) step.At(x, y) = glm::vec3(0.4f);
  }
  const Rgb8Image codes = Degradation(sizes, kSeed).Picture(step, 1.0, 0);
  EXPECT_LT(MeanSignal(codes, kWidth / 2 - 1, 0, kWidth / 2, kHeight).x, 0.08);
  EXPECT_GT(MeanSignal(codes, kWidth / 2, 0, kWidth / 2 + 1, kHeight).x, 0.44);
  EXPECT_NEAR(MeanSignal(codes, 0, 0, kWidth / 4, kHeight).x, 0.1, 1e-3);
}

// Without it a frame's pictures differ from another's by noise alone.
TEST(Degradation, AutoExposureWandersByAboutItsSize) {
  Imperfections sizes;
  sizes.exposure_ev = 0.5;
  double squares = 0.0;
  constexpr int kSeeds = 100;
  constexpr int kLate = 20;  // Long enough to settle.
  const RgbImage small(4, 4, glm::vec3(0.1f));
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Rgb8Image codes = Degradation(sizes, seed).Picture(small, 1.0, kLate);
    squares += std::pow(std::log2(MeanSignal(codes).y / 0.1), 2.0);
  }
  // sqrt(0.6^2 / (1 - 0.8^2)) = 1; a deviation over n draws is known to 1 / sqrt(2 n).
  EXPECT_NEAR(std::sqrt(squares / kSeeds), 0.5, 4.0 * 0.5 / std::sqrt(2.0 * kSeeds));
}

TEST(Degradation, ASeedDecidesAndImperfectionsDoNotDisturbEachOther) {
  Imperfections gain;
  gain.gain_log_stddev = 0.1;
  Imperfections more = gain;
  more.pose_deg = 1.0;
  more.mesh_m = 0.1;
  more.albedo_log_stddev = 0.3;
  const Rgb8Image first = Degradation(gain, 1).Picture(Flat(kColour), 1.0, 2);
  EXPECT_EQ(first.pixels, Degradation(more, 1).Picture(Flat(kColour), 1.0, 2).pixels);
  EXPECT_NE(first.pixels, Degradation(gain, 2).Picture(Flat(kColour), 1.0, 2).pixels);
  EXPECT_NE(first.pixels, Degradation(gain, 1).Picture(Flat(kColour), 1.0, 3).pixels)
      << "noise of another frame";
}

TEST(Degradation, RefusesSizesThatMakeNoSense) {
  const auto refusal = [](void (*set)(Imperfections&)) {
    Imperfections sizes;
    set(sizes);
    try {
      Degradation(sizes, 1);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal([](Imperfections& s) { s.pose_m = -0.1; }), HasSubstr("pose_m is -0.1"));
  EXPECT_THAT(refusal([](Imperfections& s) { s.curve_log_stddev = std::nan(""); }),
              HasSubstr("curve_log_stddev"));
  EXPECT_THAT(refusal([](Imperfections& s) { s.jpeg_loss = 101.0; }), HasSubstr("jpeg_loss"));
  EXPECT_THAT(refusal([](Imperfections& s) { s.vignette_share = 1.0; }), HasSubstr("vignette"));
}

// The bundled sequence, written with one imperfection.
class WrittenDegradation : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("pleinair_degraded_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Sequence Written(const Imperfections& sizes) {
    Degradation(sizes, kSeed).Write(source_, std::vector<int>{0, 4}, folder_);
    return ReadSequence(folder_);
  }
  std::string Text(const char* name) const {
    std::ifstream stream(folder_ / name);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  const Sequence source_ = ReadSequence(kCourtyard);
  fs::path folder_;
};

double AngleDeg(const glm::dmat3& rotation) {
  const double trace = rotation[0][0] + rotation[1][1] + rotation[2][2];
  return DegFromRad(std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0)));
}

TEST_F(WrittenDegradation, HasTheChosenFramesAndNoTruth) {
  const Sequence written = Written({});
  ASSERT_EQ(written.frames.size(), 2u);
  EXPECT_EQ(written.frames[1].time, source_.frames[4].time);
  EXPECT_EQ(written.frames[1].exposure, source_.frames[4].exposure);
  EXPECT_FALSE(written.frames[1].image);
  EXPECT_EQ(written.camera_from_world, source_.camera_from_world);
  EXPECT_FALSE(fs::exists(folder_ / "truth"));
  EXPECT_FALSE(fs::exists(folder_ / "frames" / "000000.exr"));
  const Rgb8Image picture = ReadDisplayImage(folder_ / *written.frames[1].image_ldr);
  const Rgb8Image taken = Degradation({}, kSeed).Picture(
      ReadRadianceImage(kCourtyard / *source_.frames[4].image), *source_.frames[4].exposure, 1);
  double squares = 0.0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    squares += std::pow(double(picture.pixels[i].y) - taken.pixels[i].y, 2.0);
  }
  // JPEG at its best: half a code of rounding, and colours at half the resolution.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(picture.pixels.size())), 2.0);
}

TEST_F(WrittenDegradation, WithholdsAnExposureThatWanders) {
  Imperfections sizes;
  sizes.exposure_ev = 0.5;
  for (const FrameEntry& frame : Written(sizes).frames) {
    EXPECT_FALSE(frame.EffectiveExposure());
  }
}

TEST_F(WrittenDegradation, TurnsAndMovesTheCamera) {
  Imperfections sizes;
  sizes.pose_deg = 0.5;
  const glm::dmat4 turned = *Written(sizes).camera_from_world;
  const glm::dmat4 off = turned * glm::inverse(*source_.camera_from_world);
  EXPECT_NEAR(AngleDeg(glm::dmat3(off)), 0.5, 1e-6);
  sizes = {};
  sizes.pose_m = 0.1;
  const glm::dvec3 shift((*Written(sizes).camera_from_world - *source_.camera_from_world)[3]);
  EXPECT_GT(glm::length(shift), 0.01);
  EXPECT_LT(glm::length(shift), 0.3);
}

TEST_F(WrittenDegradation, TurnsTheWorldButNotTheSky) {
  Imperfections sizes;
  sizes.north_deg = 2.0;
  const Sequence written = Written(sizes);
  const Mesh was = LoadMesh(kCourtyard / source_.scene_mesh).mesh;
  const Mesh is = LoadMesh(folder_ / written.scene_mesh).mesh;
  ASSERT_EQ(is.positions_m.size(), was.positions_m.size());
  for (std::size_t i = 0; i < is.positions_m.size(); ++i) {
    const glm::dvec3 a(was.positions_m[i]);
    const glm::dvec3 b(is.positions_m[i]);
    EXPECT_NEAR(a.z, b.z, 1e-4);
    const double off = std::abs(std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y));
    EXPECT_NEAR(DegFromRad(off), 2.0, 0.01);
    // What the camera sees of its mesh is where it was.
    const glm::dvec4 in_camera = *source_.camera_from_world * glm::dvec4(a, 1.0);
    const glm::dvec4 now = *written.camera_from_world * glm::dvec4(b, 1.0);
    EXPECT_LT(glm::distance(in_camera, now), 1e-3);
  }
  EXPECT_EQ(ReadRadianceImage(folder_ / "environment.exr").pixels,
            ReadRadianceImage(kCourtyard / "environment.exr").pixels);
}

TEST_F(WrittenDegradation, MovesVerticesByItsSizeAndKeepsTheGroundFlat) {
  Imperfections sizes;
  sizes.mesh_m = 0.05;
  const Sequence written = Written(sizes);
  // Vertices of one place stay together, so the file's order is kept: line by line.
  std::ifstream was_file(kCourtyard / source_.scene_mesh);
  std::ifstream is_file(folder_ / written.scene_mesh);
  double squares = 0.0;
  int above_ground = 0;
  std::string was;
  std::string is;
  while (std::getline(was_file, was) && std::getline(is_file, is)) {
    if (!was.starts_with("v ")) {
      EXPECT_EQ(is, was);
      continue;
    }
    glm::dvec3 a(0.0);
    glm::dvec3 b(0.0);
    ASSERT_EQ(std::sscanf(was.c_str(), "v %lf %lf %lf", &a.x, &a.y, &a.z), 3);
    ASSERT_EQ(std::sscanf(is.c_str(), "v %lf %lf %lf", &b.x, &b.y, &b.z), 3);
    if (std::abs(a.z) < 0.02) {
      EXPECT_NEAR(a.z, b.z, 1e-5);
      continue;
    }
    squares += glm::dot(b - a, b - a);
    ++above_ground;
  }
  ASSERT_GT(above_ground, 30);
  EXPECT_NEAR(std::sqrt(squares / above_ground), 0.05, 0.015);
}

TEST_F(WrittenDegradation, ClipsTheSurveyMapAtItsSky) {
  Imperfections sizes;
  sizes.map_clipped_at = 6.0;
  Written(sizes);
  const RgbImage was = ReadRadianceImage(kCourtyard / "environment.exr");
  const RgbImage is = ReadRadianceImage(folder_ / "environment.exr");
  float brightest = 0.0f;
  std::vector<double> sky;
  for (std::size_t i = 0; i < is.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) brightest = std::max(brightest, is.pixels[i][c]);
    const glm::vec3& rgb = was.pixels[i];
    if (i < is.pixels.size() / 2) sky.push_back(std::max({rgb.x, rgb.y, rgb.z}));
  }
  EXPECT_NEAR(brightest, 6.0 * Percentile(sky, 0.99), 1e-3 * brightest);
}

TEST_F(WrittenDegradation, GuessesAlbedosWhereTheMapIsWithheld) {
  Imperfections sizes;
  sizes.map_withheld = true;
  const Sequence written = Written(sizes);
  EXPECT_FALSE(written.environment);
  EXPECT_TRUE(written.albedos_assumed);
  EXPECT_THAT(Text("scene.mtl"), HasSubstr("Kd 0.3345 0.1840 0.1420")) << "the mean of brick_red";

  sizes.albedo_log_stddev = 0.4;
  Written(sizes);
  std::istringstream lines(Text("scene.mtl"));
  const std::map<std::string, glm::dvec3> albedos = ReadTrueAlbedos(source_);
  double squares = 0.0;
  int guesses = 0;
  std::string name;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("newmtl ")) name = line.substr(7);
    glm::dvec3 kd(0.0);
    if (std::sscanf(line.c_str(), "Kd %lf %lf %lf", &kd.x, &kd.y, &kd.z) != 3) continue;
    const auto found = albedos.find(name);
    if (found == albedos.end()) continue;
    for (int c = 0; c < 3; ++c, ++guesses) {
      squares += std::pow(std::log(kd[c] / found->second[c]), 2.0);
    }
  }
  ASSERT_GE(guesses, 12);
  EXPECT_NEAR(std::sqrt(squares / guesses), 0.4, 0.25);
}

TEST_F(WrittenDegradation, RefusesWhatItCannotDegrade) {
  Sequence source = source_;
  source.frames[4].exposure.reset();
  EXPECT_THROW(Degradation({}, 1).Write(source, std::vector<int>{4}, folder_), std::runtime_error);
  source = source_;
  source.frames[0].image.reset();
  EXPECT_THROW(Degradation({}, 1).Write(source, std::vector<int>{0}, folder_), std::runtime_error);
}

}  // namespace
}  // namespace pleinair::degradation_test
