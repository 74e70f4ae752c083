// Sites: what a sequence says of its place, without its pictures; and their camera at another size.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "datasets/camera/live_frame_source.h"
#include "sunmodel/time_text.h"
#include "tests/datasets/sequence_fixture.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SiteFolder : public SequenceFolder {
 protected:
  // Every key that a site has.
  static nlohmann::json EverySiteKey() {
    nlohmann::json site = Everything();
    site["format"] = "pleinair-site";
    site.erase("frames");
    site.erase("weather");
    return site;
  }
  void WriteSite(const nlohmann::json& document) { Write(folder_ / "site.json", document.dump()); }
  Sequence Read() const { return ReadSite(folder_, kNoon); }
  // One line, or empty.
  std::string RefusalOfSite() const {
    std::string text = MessageOf([&] { Read(); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }

  inline static const UtcTime kNoon = ParseUtcTime("2026-06-21T12:00:00Z");
};

TEST_F(SiteFolder, ASiteIsItsSequenceWithoutPictures) {
  WriteSite(EverySiteKey());
  const Sequence site = Read();
  WriteDocument(Everything());
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_EQ(site.intrinsics, sequence.intrinsics);
  EXPECT_EQ(site.camera_from_world, sequence.camera_from_world);
  EXPECT_EQ(site.site->latitude_rad, sequence.site->latitude_rad);
  EXPECT_EQ(site.north_stddev_rad, sequence.north_stddev_rad);
  EXPECT_EQ(site.diffuse_regions, sequence.diffuse_regions);
  EXPECT_EQ(site.environment->image, sequence.environment->image);
  EXPECT_EQ(site.virtual_objects.size(), sequence.virtual_objects.size());
  EXPECT_FALSE(site.HasPictures());
  EXPECT_TRUE(sequence.HasPictures());
  // The camera where it stands, at the time that was asked for.
  ASSERT_EQ(site.frames.size(), 1u);
  EXPECT_EQ(site.frames[0].time, kNoon);
  EXPECT_EQ(site.CameraOfFrame(0).camera_from_world, *sequence.camera_from_world);
}

TEST_F(SiteFolder, ASequencesFolderIsASiteWithoutItsDaysWeather) {
  WriteDocument(Everything());
  const Sequence site = Read();
  EXPECT_FALSE(site.HasPictures());
  EXPECT_FALSE(site.WeatherOfFrame(0));
  EXPECT_EQ(site.frames.at(0).time, kNoon);
  EXPECT_EQ(site.CameraOfFrame(0).camera_from_world, *ReadSequence(folder_).camera_from_world);
  const Sequence overcast = ReadSite(folder_, kNoon, SequencePoses::kRequired, Weather::kOvercast);
  EXPECT_EQ(overcast.WeatherOfFrame(0), Weather::kOvercast);
}

TEST_F(SiteFolder, WithoutAPoseOfTheCameraTheFirstFramesIsUsed) {
  nlohmann::json document = Everything();
  document["camera"].erase("camera_from_world");
  document["frames"][1]["camera_from_world"] = {
      {1, 0, 0, 7}, {0, 0, -1, 7}, {0, 1, 0, 7}, {0, 0, 0, 1}};
  WriteDocument(document);
  EXPECT_EQ(*Read().camera_from_world, *ReadSequence(folder_).frames.at(0).camera_from_world);
}

TEST_F(SiteFolder, SiteJsonComesBeforeASequence) {
  nlohmann::json site = EverySiteKey();
  site["name"] = "the site";
  WriteSite(site);
  WriteDocument(Everything());
  EXPECT_EQ(Read().name, "the site");
  fs::remove(folder_ / "site.json");
  EXPECT_EQ(Read().name, "everything");
}

TEST_F(SiteFolder, ASiteHasNoFramesAndNoWeather) {
  for (const char* key : {"frames", "weather"}) {
    nlohmann::json site = EverySiteKey();
    site[key] = Everything()[key];
    WriteSite(site);
    EXPECT_THAT(RefusalOfSite(),
                AllOf(HasSubstr("site.json: " + std::string(key)),
                      HasSubstr("a site, which has no such key")));
  }
}

TEST_F(SiteFolder, ASiteNeedsWhatTheCameraSeesAndStandsAt) {
  for (const char* key : {"camera", "scene", "version", "format"}) {
    nlohmann::json site = EverySiteKey();
    site.erase(key);
    WriteSite(site);
    EXPECT_THAT(RefusalOfSite(), HasSubstr(key)) << key;
  }
  nlohmann::json site = EverySiteKey();
  site["camera"].erase("camera_from_world");
  WriteSite(site);
  EXPECT_THAT(RefusalOfSite(), AllOf(HasSubstr("camera"), HasSubstr("where the camera stands")));
  EXPECT_FALSE(ReadSite(folder_, kNoon, SequencePoses::kMayBeAbsent).camera_from_world);
  site = EverySiteKey();
  site["versions"] = 1;
  WriteSite(site);
  EXPECT_THAT(RefusalOfSite(), HasSubstr("versions"));
}

// Without a place, a map or a fish-eye camera nothing says where the sun is.
TEST_F(SiteFolder, ASiteSaysWhereTheSunIs) {
  nlohmann::json site = EverySiteKey();
  site.erase("site");
  site.erase("environment");
  site.erase("fisheye");
  WriteSite(site);
  EXPECT_THAT(RefusalOfSite(), HasSubstr("nothing says where the sun is"));
}

TEST_F(SiteFolder, ASiteIsNoSequence) {
  nlohmann::json site = EverySiteKey();
  WriteDocument(site);
  EXPECT_THAT(MessageOf([&] { ReadSequence(folder_); }), HasSubstr("\"pleinair-sequence\""));
}

TEST_F(SiteFolder, NothingOutsideTheFolderIsRead) {
  Write(root_ / "site.json", EverySiteKey().dump());
  fs::create_symlink(root_ / "site.json", folder_ / "site.json");
  EXPECT_THAT(RefusalOfSite(), HasSubstr("expected a file inside the site's folder"));
  fs::remove(folder_ / "site.json");
  fs::create_symlink(root_ / "outside.obj", folder_ / "link.obj");
  for (const char* mesh : {"../outside.obj", "link.obj"}) {
    nlohmann::json site = EverySiteKey();
    site["scene"]["mesh"] = mesh;
    WriteSite(site);
    EXPECT_THAT(RefusalOfSite(), HasSubstr("scene.mesh")) << mesh;
  }
}

TEST_F(SiteFolder, AFolderWithoutEitherFileIsRefused) {
  EXPECT_THAT(RefusalOfSite(), Not(testing::IsEmpty()));
  EXPECT_THAT(MessageOf([] { ReadSite("/no/such/folder", kNoon); }), HasSubstr("/no/such/folder"));
}

CameraIntrinsics Vga() {
  CameraIntrinsics camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 500.0;
  camera.fy_px = 505.0;
  camera.cx_px = 322.0;
  camera.cy_px = 236.0;
  camera.distortion = {-0.1, 0.02, 0.001, -0.002, 0.003};
  return camera;
}

// Pixels' corners scale: a point that is seen at the same share of the picture's width and height.
TEST(ScaledTo, SeesTheSamePointAtTheSameShareOfThePicture) {
  const CameraIntrinsics camera = Vga();
  for (const auto& [width, height] : {std::pair{320, 240}, {1280, 960}, {1600, 1200}, {641, 480}}) {
    const CameraIntrinsics scaled = ScaledTo(camera, width, height);
    EXPECT_EQ(scaled.width_px, width);
    EXPECT_EQ(scaled.height_px, height);
    EXPECT_EQ(scaled.distortion, camera.distortion);
    for (const double slope : {-0.4, 0.0, 0.3}) {
      const auto share = [&](double focal, double centre, int side) {
        return (focal * slope + centre + 0.5) / side;
      };
      EXPECT_NEAR(share(scaled.fx_px, scaled.cx_px, width),
                  share(camera.fx_px, camera.cx_px, camera.width_px),
                  1e-12);
      EXPECT_NEAR(share(scaled.fy_px, scaled.cy_px, height),
                  share(camera.fy_px, camera.cy_px, camera.height_px),
                  1e-12);
    }
    const CameraIntrinsics back = ScaledTo(scaled, camera.width_px, camera.height_px);
    EXPECT_NEAR(back.cx_px, camera.cx_px, 1e-9);
    EXPECT_NEAR(back.fy_px, camera.fy_px, 1e-9);
  }
  EXPECT_EQ(ScaledTo(camera, camera.width_px, camera.height_px), camera);
}

TEST(ScaledTo, RefusesAnotherShape) {
  for (const auto& [width, height] : {std::pair{1280, 720}, {480, 640}, {645, 480}, {640, 0}}) {
    EXPECT_THAT(MessageOf([&, w = width, h = height] { ScaledTo(Vga(), w, h); }),
                HasSubstr("expected the shape of the site's camera, 640x480, found"))
        << width << "x" << height;
  }
}

}  // namespace
}  // namespace pleinair::site_test
