// `pleinair site mask` on a copy of the bundled courtyard, into which something is painted.
#include "apps/site_mask_command.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "datasets/diffuse_mask.h"
#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_mask_command_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(SiteMask, FindsWhatStandsInTwoOfSixFramesAndWritesIt) {
  const TemporaryFolder folder;
  const fs::path sequence = folder / "courtyard";
  fs::copy(fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard",
           sequence,
           fs::copy_options::recursive);
  const fs::path first = sequence / "frames/000002.exr";
  const int width = ReadRadianceImage(first).width;
  const int height = ReadRadianceImage(first).height;
  // On the paving, in the lower right part.
  const int left = width * 6 / 10;
  const int top = height * 8 / 10;
  const int side = height / 8;
  for (const char* name : {"frames/000002.exr", "frames/000003.exr"}) {
    RgbImage picture = ReadRadianceImage(sequence / name);
    for (int y = top; y < top + side; ++y) {
      for (int x = left; x < left + side; ++x) {
        picture.At(x, y) *= glm::vec3(4.0f, 0.3f, 0.3f);
      }
    }
    WriteExr(sequence / name, picture, ExrPrecision::kFloat);
  }
  SiteMaskOptions options;
  options.session.sequence = sequence;
  options.session.cache = folder / "cache";
  options.session.prepare.patch_size_m = 4.0;
  options.session.prepare.rays = 64;
  options.overview = folder / "overview.png";
  options.write = true;
  const std::string report = RunSiteMask(options);
  EXPECT_THAT(report, HasSubstr("6 frames used, 0 left out"));
  EXPECT_THAT(report, HasSubstr("paving"));

  const auto mask = ReadDiffuseMask(ReadSequence(sequence));
  ASSERT_TRUE(mask);
  EXPECT_FALSE(mask->is_over_map);
  int masked = 0;
  int on_paving = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool is_box = x >= left && x < left + side && y >= top && y < top + side;
      const bool is_masked = mask->image.At(x, y) == 0;
      masked += is_box && is_masked;
      const bool is_near =
          x >= left - 4 && x < left + side + 4 && y >= top - 4 && y < top + side + 4;
      on_paving += is_masked && !is_near && y > height * 7 / 10;
    }
  }
  EXPECT_EQ(masked, side * side);
  EXPECT_EQ(on_paving, 0);
  EXPECT_EQ(ReadDisplayImage(folder / "overview.png").width, width);
}

TEST(SiteMask, SaysInOneLineWhatItNeeds) {
  SiteMaskOptions options;
  options.session.sequence = "no-such-sequence";
  EXPECT_THAT(MessageOf([&] { RunSiteMask(options); }), HasSubstr("no-such-sequence"));
}

}  // namespace
}  // namespace pleinair::site_mask_command_test
