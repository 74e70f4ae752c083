// Runs of real pictures, made into sequences by scripts/make-real-sequences: as good as they were,
// and never absurd. The others of datasets/baselines/real-pictures.json are checked by `pleinair
// regress` (docs/regress.md).
#include <cstdlib>

#include <string>

#include <gtest/gtest.h>

#include "apps/regression_baseline.h"
#include "tests/session/command_folder.h"

namespace pleinair::real_pictures_recorded_test {
namespace {

namespace fs = std::filesystem;

const fs::path kShared = PLEINAIR_SHARED_DIR;

bool Succeeds(const std::string& command) {
  return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

class RealPictures : public CommandFolder {
 protected:
  void SetUp() override {
    CommandFolder::SetUp();
    if (!fs::exists(kShared / "groundtruth/real") || !fs::exists(kShared / "data")) {
      GTEST_SKIP() << kShared << ": no real pictures there";
    }
    if (!Succeeds("/usr/bin/python3 -c 'import cv2, numpy'")) {
      GTEST_SKIP() << "needs Debian's python3-numpy and python3-opencv to make the sequences";
    }
  }

  void Make(const std::string& name) {
    ASSERT_TRUE(Succeeds("'" PLEINAIR_SOURCE_DIR "/scripts/make-real-sequences' '" +
                         kShared.string() + "' '" + folder_.string() + "' " + name));
  }

  // With the baseline's settings; no figure may have got worse.
  RunToJudge RunAsGoodAsItsBaseline(const std::string& name) {
    static const RegressionBaseline baseline =
        ReadRegressionBaseline(PLEINAIR_SOURCE_DIR "/datasets/baselines/real-pictures.json");
    const SequenceBaseline& before = baseline.at(name);
    RunToJudge run = RunForFigures(folder_ / name, before.settings, 1, folder_ / "cache").at(0);
    SeededFigures now;
    AddSeed(FiguresOf(run), now);
    for (const FigureComparison& figure : CompareFigures(before.figures, now)) {
      EXPECT_FALSE(figure.GotWorse()) << name << ": " << figure.Reason();
    }
    return run;
  }

  static void ExpectAllCompositedWithoutABadPixel(const RunToJudge& run, std::size_t frames) {
    EXPECT_EQ(run.done.size(), frames);
    EXPECT_EQ(run.frames_failed, 0);
    for (const FrameFacts& frame : run.done) {
      EXPECT_EQ(frame.glowing_pixels, 0);
      EXPECT_EQ(frame.clamped_pixels, 0);
    }
  }
};

// The survey's own view 0 s, 1 s, 10 s, 10 min and 1 h after it, as light and as a phone's picture
// whose exposure nobody knows: no cyan object, no hard shadow, at any time.
TEST_F(RealPictures, AnOvercastSquareStaysOvercastForAnHour) {
  Make("potsdamer_platz");
  for (const char* name : {"potsdamer_platz", "potsdamer_platz-phone"}) {
    const RunToJudge run = RunAsGoodAsItsBaseline(name);
    ExpectAllCompositedWithoutABadPixel(run, 5);
    const glm::dvec3& first = run.done.at(0).sky_irradiance_rgb;
    for (const FrameFacts& frame : run.done) {
      EXPECT_LE(SunOverSky(frame), 0.03) << name;
      EXPECT_GE(SkyHue(frame), 0.25) << name;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(frame.sky_irradiance_rgb[c], first[c], 0.1 * first[c]) << name;
      }
    }
  }
}

// Pictures, a guessed lens and pose, one plane: no survey, no exposure, fog and forest.
TEST_F(RealPictures, AYearOfAFixedCameraHasNoBadPixel) {
  Make("year");
  ExpectAllCompositedWithoutABadPixel(RunAsGoodAsItsBaseline("year"), 8);
}

TEST_F(RealPictures, CarsUnderAnOvercastSkyGetNoSun) {
  Make("clip");
  const RunToJudge run = RunAsGoodAsItsBaseline("clip");
  ExpectAllCompositedWithoutABadPixel(run, 8);
  for (const FrameFacts& frame : run.done) EXPECT_FALSE(ShowsSun(frame));
}

}  // namespace
}  // namespace pleinair::real_pictures_recorded_test
