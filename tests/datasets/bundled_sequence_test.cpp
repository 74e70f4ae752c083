// The sequence that comes with the program.
#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "datasets/frame_source.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"

namespace pleinair::bundled_sequence_test {
namespace {

namespace fs = std::filesystem;

const fs::path kBundled = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

TEST(BundledSequence, PlaysToItsEnd) {
  const Sequence sequence = ReadSequence(kBundled);
  EXPECT_EQ(sequence.name, "courtyard");
  EXPECT_TRUE(sequence.environment);
  EXPECT_EQ(sequence.virtual_objects.size(), 1u);
  const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  int frames = 0;
  while (const auto next = source->Next()) {
    ASSERT_TRUE(next->has_value()) << next->error().reason;
    EXPECT_EQ(std::count((*next)->unusable.pixels.begin(), (*next)->unusable.pixels.end(), 1), 0);
    ++frames;
  }
  EXPECT_EQ(frames, 6);
}

TEST(BundledSequence, StaysSmall) {
  std::uintmax_t total = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kBundled)) {
    if (!entry.is_regular_file()) continue;
    EXPECT_LT(entry.file_size(), 2'000'000u) << entry.path();
    total += entry.file_size();
  }
  EXPECT_LT(total, 4'000'000u);
}

// Rounded mantissas: every value within 2^-7, and what the map adds up to, disc included, within a
// hundredth of that (200 000 independent roundings of the upper hemisphere; the disc's few pixels
// share one true value, so they may round in the same way: 2^-7 of its part).
TEST(BundledSequence, HasTheRecordingsSurveyMap) {
  const fs::path recorded =
      fs::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds/environment.exr";
  if (!fs::exists(recorded)) GTEST_SKIP() << "no recording " << recorded;
  const RgbImage expected = ReadRadianceImage(recorded);
  const RgbImage bundled = ReadRadianceImage(kBundled / "environment.exr");
  ASSERT_EQ(bundled.pixels.size(), expected.pixels.size());
  glm::dvec3 sky_expected(0.0);
  glm::dvec3 sky_bundled(0.0);
  for (int y = 0; y < expected.height / 2; ++y) {
    const double solid_angle =
        LatLongPixelSolidAngleSr(y, LatLongSize{expected.width, expected.height});
    for (int x = 0; x < expected.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(bundled.At(x, y)[c], expected.At(x, y)[c], expected.At(x, y)[c] / 128.0f);
      }
      if (expected.At(x, y).y > 1e4f) continue;
      sky_expected += solid_angle * glm::dvec3(expected.At(x, y));
      sky_bundled += solid_angle * glm::dvec3(bundled.At(x, y));
    }
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sky_bundled[c] / sky_expected[c], 1.0, 1.0 / 12800.0);
}

}  // namespace
}  // namespace pleinair::bundled_sequence_test
