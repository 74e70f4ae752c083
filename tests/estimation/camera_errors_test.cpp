// What frames teach of a camera's errors.
#include "estimation/camera_errors.h"

#include <cmath>

#include <gtest/gtest.h>

namespace pleinair::camera_errors_test {
namespace {

// Of frames that all show 0.3 +/- 0.06 without what is known beforehand.
LearnedError FoundFrom(const LearnedError& known) {
  const double of_frame = 1.0 / (0.06 * 0.06);
  const double of_known = 1.0 / (known.stddev * known.stddev);
  const double information = of_frame + of_known;
  return {(of_frame * 0.3 + of_known * known.value) / information, 1.0 / std::sqrt(information)};
}

TEST(LearnedError, GathersTheEvidenceOfFrames) {
  const LearnedError before{0.08, 0.1};
  LearnedError known = before;
  for (int frame = 0; frame < 4; ++frame) {
    known = WithEvidence(known, before, FoundFrom(before), 1.0);
  }
  const double of_frames = 4.0 / (0.06 * 0.06);
  EXPECT_NEAR(known.stddev, 1.0 / std::sqrt(of_frames + 100.0), 1e-12);
  EXPECT_NEAR(known.value, (of_frames * 0.3 + 100.0 * 0.08) / (of_frames + 100.0), 1e-12);
}

// However many frames show the same, what was known beforehand keeps its part of the answer.
TEST(LearnedError, StopsWhereMoreFramesTellNoMore) {
  LearnedError known{0.08, 0.1};
  for (int frame = 0; frame < 100; ++frame) {
    known = WithEvidenceDownTo(0.04, known, FoundFrom(known), 1.0);
  }
  const double all = 1.0 / (0.04 * 0.04);
  EXPECT_NEAR(known.stddev, 0.04, 1e-9);
  EXPECT_NEAR(known.value, ((all - 100.0) * 0.3 + 100.0 * 0.08) / all, 1e-9);
  // Known better beforehand, it is not forgotten.
  const LearnedError stated{0.0, 0.03};
  const LearnedError after = WithEvidenceDownTo(0.04, stated, FoundFrom(stated), 1.0);
  EXPECT_EQ(after.value, 0.0);
  EXPECT_EQ(after.stddev, 0.03);
}

}  // namespace
}  // namespace pleinair::camera_errors_test
