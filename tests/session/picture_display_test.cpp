#include "session/picture_display.h"

#include <gtest/gtest.h>

namespace pleinair::picture_display_test {
namespace {

// A picture of two pixels, of which an object changes the second.
struct Shown {
  Frame frame;
  Composite composite;

  Shown(const glm::u8vec3& left, const glm::u8vec3& right) {
    Rgb8Image codes(2, 1);
    codes.pixels = {left, right};
    frame.codes = codes;
    frame.exposure = 1.0;
    composite.radiance = RgbImage(2, 1);
    composite.radiance.pixels = {glm::vec3(0.9f), glm::vec3(0.4f, 0.2f, 0.1f)};
    composite.change = Gray8Image(2, 1);
    composite.change.pixels = {static_cast<std::uint8_t>(PixelChange::kNone),
                               static_cast<std::uint8_t>(PixelChange::kCovered)};
  }
};

TEST(PictureDisplay, KeepsThePixelsThatNothingChanges) {
  const Shown shown({10, 20, 30}, {40, 50, 60});
  PictureDisplay display(ResponseCurve::Srgb());
  const Rgb8Image picture = display.Show(shown.frame, shown.composite);
  EXPECT_EQ(picture.pixels[0], glm::u8vec3(10, 20, 30));
  EXPECT_GT(picture.pixels[1].r, picture.pixels[1].g);
  EXPECT_GT(picture.pixels[1].g, picture.pixels[1].b);
}

// A camera without colours shows none of an object either.
TEST(PictureDisplay, ShowsNoColoursWhereTheCameraHasNone) {
  const Shown shown({10, 10, 10}, {40, 40, 40});
  PictureDisplay display(ResponseCurve::Srgb());
  for (const double stops : {0.0, 1.0}) {
    const Rgb8Image picture = display.Show(shown.frame, shown.composite, stops);
    if (stops == 0.0) {
      EXPECT_EQ(picture.pixels[0], glm::u8vec3(10));
    }
    const glm::u8vec3& grey = picture.pixels[1];
    EXPECT_EQ(grey, glm::u8vec3(grey.g));
    PictureDisplay in_colour(ResponseCurve::Srgb());
    const Shown coloured({10, 20, 30}, {40, 50, 60});
    const glm::u8vec3 colour = in_colour.Show(coloured.frame, coloured.composite, stops).pixels[1];
    EXPECT_GT(grey.g, colour.b);
    EXPECT_LT(grey.g, colour.r);
  }
}

// In the dark, or where it clips, a camera with colours delivers grey as well.
TEST(PictureDisplay, TakesBlackAndWhitePicturesForNoGreyCameras) {
  for (const int code : {0, 255}) {
    const glm::u8vec3 clipped(static_cast<std::uint8_t>(code));
    const Shown shown(clipped, clipped);
    PictureDisplay display(ResponseCurve::Srgb());
    const Rgb8Image picture = display.Show(shown.frame, shown.composite);
    EXPECT_GT(picture.pixels[1].r, picture.pixels[1].b) << code;
  }
}

}  // namespace
}  // namespace pleinair::picture_display_test
