#include "datasets/sequence.h"

#include "sunmodel/time_text.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::sequence_test {
namespace {

using SequenceTest = SequenceFolder;

TEST_F(SequenceTest, ReadsEveryKey) {
  WriteDocument(Everything());
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_EQ(sequence.folder, folder_);
  EXPECT_EQ(sequence.name, "everything");
  ASSERT_TRUE(sequence.site);
  EXPECT_NEAR(sequence.site->latitude_rad, 0.995689394, 1e-9);
  EXPECT_EQ(sequence.site->height_m, 15.0);
  EXPECT_NEAR(sequence.north_stddev_rad, 0.0436332313, 1e-9);
  EXPECT_EQ(sequence.weather, Weather::kBroken);
  EXPECT_EQ(sequence.intrinsics.width_px, 8);
  EXPECT_EQ(sequence.intrinsics.fy_px, 10.25);
  EXPECT_EQ(sequence.intrinsics.distortion[3], -0.001);
  // Row-major in the file: row 1 is y = -Z + 1.5.
  const glm::dvec4 point = *sequence.camera_from_world * glm::dvec4(0.0, 0.0, 1.0, 1.0);
  EXPECT_EQ(point, glm::dvec4(0.5, 0.5, 2.5, 1.0));
  EXPECT_EQ(sequence.response_ldr, "srgb8");
  EXPECT_EQ(sequence.scene_mesh, "scene.obj");
  EXPECT_FALSE(sequence.albedos_known);
  EXPECT_TRUE(sequence.albedos_assumed);
  ASSERT_EQ(sequence.windows.size(), 1u);
  EXPECT_EQ(sequence.windows[0].name, "south");
  EXPECT_EQ(sequence.windows[0].polygon_world_m[2], glm::dvec3(1.0, 0.0, 2.0));
  EXPECT_EQ(sequence.diffuse_regions, (std::vector<std::string>{"paving", "wall"}));
  EXPECT_EQ(sequence.diffuse_mask, "mask.png");
  ASSERT_TRUE(sequence.environment);
  EXPECT_EQ(sequence.environment->image, "environment.exr");
  EXPECT_EQ(sequence.environment->time, ParseUtcTime("2005-06-21T09:50:00.25Z"));
  EXPECT_EQ(sequence.environment->position_m, glm::dvec3(-1.25, 2.0, 1.5));
  ASSERT_TRUE(sequence.fisheye);
  EXPECT_EQ(sequence.fisheye->height_px, 500);
  EXPECT_EQ(sequence.fisheye->image_right, "+X east");
  ASSERT_EQ(sequence.virtual_objects.size(), 1u);
  EXPECT_EQ(sequence.virtual_objects[0].world_from_object[3], glm::dvec4(1.0, 2.0, 3.0, 1.0));
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].exposure, 0.0125);
  EXPECT_EQ(sequence.frames[0].sun_direction_enu, glm::dvec3(0.0, -0.6, 0.8));
  EXPECT_EQ(sequence.frames[0].sample_polygons[0].sun, JudgedSun::kGrazing);
  EXPECT_EQ(sequence.frames[0].sample_polygons[0].polygon_px[1], glm::dvec2(4.5, 0.0));
  EXPECT_EQ(sequence.WeatherOfFrame(0), Weather::kClear);
  EXPECT_EQ(sequence.WeatherOfFrame(1), Weather::kBroken);
  EXPECT_FALSE(sequence.frames[1].image);
  EXPECT_EQ(sequence.frames[1].time, ParseUtcTime("2005-06-21T10:30:00.5Z"));
}

TEST_F(SequenceTest, NeedsOnlyAFewKeys) {
  const nlohmann::json document = nlohmann::json::parse(R"({
    "format": "pleinair-sequence", "version": 1,
    "site": {"latitude_deg": 0, "longitude_deg": 0, "height_m": 0},
    "camera": {"width": 8, "height": 6, "fx": 10, "fy": 10, "cx": 3.5, "cy": 2.5,
      "camera_from_world": [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]},
    "scene": {"mesh": "scene.obj"},
    "frames": [{"image_ldr": "a.png", "time_utc": "2005-06-21T10:00:00Z"}]})");
  WriteDocument(document);
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_EQ(sequence.name, "sequence");
  EXPECT_EQ(sequence.response_ldr, "srgb8");
  EXPECT_FALSE(sequence.environment);
  EXPECT_TRUE(sequence.virtual_objects.empty());
  EXPECT_FALSE(sequence.intrinsics.HasDistortion());
  EXPECT_FALSE(sequence.frames[0].EffectiveExposure());
  EXPECT_FALSE(sequence.StatedSunDirectionEnu(0));
  EXPECT_FALSE(sequence.WeatherOfFrame(0));
  EXPECT_EQ(sequence.north_stddev_rad, 0.0);
}

TEST_F(SequenceTest, ComesBackAsItWasWritten) {
  nlohmann::json document = Everything();
  for (const bool several : {false, true}) {
    if (several) {
      document["virtual_objects"] = {document["virtual_object"], document["virtual_object"]};
      document["virtual_objects"][1]["world_from_object"][2][3] = 7.5;
      document.erase("virtual_object");
      document["radiometry"]["frames_ldr"] = "response.json";
    }
    WriteDocument(document);
    const Sequence first = ReadSequence(folder_);
    WriteSequence(first, folder_);
    const Sequence second = ReadSequence(folder_);
    // Angles pass through radians and back: two roundings.
    EXPECT_NEAR(second.site->longitude_rad, first.site->longitude_rad, 1e-15);
    EXPECT_EQ(second.response_ldr, first.response_ldr);
    EXPECT_EQ(second.virtual_objects.size(), several ? 2u : 1u);
    nlohmann::json written = nlohmann::json::parse(std::ifstream(folder_ / "sequence.json"));
    WriteSequence(second, folder_);
    nlohmann::json again = nlohmann::json::parse(std::ifstream(folder_ / "sequence.json"));
    written.erase("site");
    again.erase("site");
    EXPECT_EQ(again, written);
    // And nothing of the document is lost but free text and how the object is listed.
    nlohmann::json expected = document;
    for (const char* gone : {"world", "note_source", "site"}) expected.erase(gone);
    expected["environment"]["mapping"].erase("formula");
    if (!several) {
      expected["virtual_objects"] = {expected["virtual_object"]};
      expected.erase("virtual_object");
    }
    EXPECT_EQ(written, expected);
  }
}

TEST_F(SequenceTest, WritesCompleteFilesOrNone) {
  WriteDocument(Everything());
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_THROW(WriteSequence(sequence, folder_ / "absent"), std::runtime_error);
  WriteSequence(sequence, folder_);
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".part");
  }
}

// value / (t ISO / N^2) is the relative radiance: 0.001 * 100 / 6.25.
TEST_F(SequenceTest, TakesTheExposureFromCameraSettingsWhereNoneIsGiven) {
  FrameEntry frame;
  frame.exposure_s = 0.001;
  frame.iso = 100.0;
  EXPECT_FALSE(frame.EffectiveExposure());
  frame.f_number = 2.5;
  EXPECT_NEAR(*frame.EffectiveExposure(), 0.016, 1e-15);
  frame.exposure = 3.0;
  EXPECT_EQ(*frame.EffectiveExposure(), 3.0);
}

TEST_F(SequenceTest, LetsTheFramesPoseWinOverTheCameras) {
  WriteDocument(Everything());
  const Sequence sequence = ReadSequence(folder_);
  EXPECT_EQ(sequence.CameraOfFrame(0).camera_from_world, *sequence.frames[0].camera_from_world);
  EXPECT_EQ(sequence.CameraOfFrame(1).camera_from_world, *sequence.camera_from_world);
  EXPECT_THROW(sequence.CameraOfFrame(2), std::out_of_range);
}

// With a site the sun is computed, unless the frame itself says where it is.
TEST_F(SequenceTest, LetsAStatedSunStandInForTheSite) {
  nlohmann::json document = Everything();
  document.erase("fisheye");
  document["frames"][0].erase("fisheye");
  WriteDocument(document);
  EXPECT_FALSE(ReadSequence(folder_).StatedSunDirectionEnu(1));

  document.erase("site");
  WriteDocument(document);
  EXPECT_EQ(ReadSequence(folder_).StatedSunDirectionEnu(0), glm::dvec3(0.0, -0.6, 0.8));
  EXPECT_EQ(ReadSequence(folder_).StatedSunDirectionEnu(1), glm::dvec3(0.6, 0.0, 0.8));

  document["environment"] = {{"sun_direction_enu", {0.8, 0.0, 0.6}}};
  WriteDocument(document);
  const Sequence without_map = ReadSequence(folder_);
  EXPECT_FALSE(without_map.environment);
  EXPECT_EQ(without_map.StatedSunDirectionEnu(1), glm::dvec3(0.8, 0.0, 0.6));
  WriteSequence(without_map, folder_);
  EXPECT_EQ(ReadSequence(folder_).StatedSunDirectionEnu(1), glm::dvec3(0.8, 0.0, 0.6));

  document.erase("environment");
  EXPECT_NE(Refusal(document).find("site: expected latitude_deg, longitude_deg and height_m, or "
                                   "frames[1].sun_direction_enu"),
            std::string::npos);
  document["frames"][1]["sun_direction_enu"] = {0.0, 0.0, 1.0};
  EXPECT_EQ(Refusal(document), "accepted");
}

// A photograph by itself: the refusal names the keys that help, and each of them does. A survey map
// may show where the sun is.
TEST_F(SequenceTest, NeedsAPlaceASunACloudOrAMap) {
  nlohmann::json document = Everything();
  for (const char* gone : {"fisheye", "site", "weather"}) document.erase(gone);
  document["frames"][0].erase("fisheye");
  document["environment"].erase("sun_direction_enu");
  EXPECT_EQ(Refusal(document), "accepted");
  document.erase("environment");
  const std::string refusal = Refusal(document);
  for (const char* key : {"site", "frames[1].sun_direction_enu", "frames[1].weather"}) {
    EXPECT_NE(refusal.find(key), std::string::npos) << refusal;
  }
  EXPECT_EQ(ReadSequence(folder_, SequencePoses::kRequired, Weather::kOvercast).WeatherOfFrame(0),
            Weather::kOvercast);
  EXPECT_THROW(ReadSequence(folder_, SequencePoses::kRequired, Weather::kBroken),
               std::runtime_error);
  document["frames"][1]["weather"] = "clear";
  EXPECT_EQ(Refusal(document), refusal);
  document["frames"][1]["weather"] = "overcast";
  EXPECT_EQ(Refusal(document), "accepted");
}

TEST_F(SequenceTest, TakesTheWeatherThatIsAskedForInPlaceOfItsOwn) {
  WriteDocument(Everything());
  const Sequence sequence = ReadSequence(folder_, SequencePoses::kRequired, Weather::kOvercast);
  EXPECT_EQ(sequence.WeatherOfFrame(0), Weather::kOvercast);
  EXPECT_EQ(sequence.WeatherOfFrame(1), Weather::kOvercast);
}

TEST_F(SequenceTest, ReadsTheRecordedOnes) {
  const std::filesystem::path shared = std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences";
  if (!std::filesystem::is_directory(shared)) GTEST_SKIP() << "no recordings in " << shared;
  EXPECT_EQ(ReadSequence(shared / "courtyard-clouds").frames.size(), 24u);
  EXPECT_EQ(ReadSequence(shared / "parking-shadow").frames.size(), 10u);
  const Sequence room = ReadSequence(shared / "room-window");
  EXPECT_EQ(room.fisheye->model, "equidistant");
  EXPECT_EQ(room.windows.size(), 1u);
  const Sequence photos = ReadSequence(shared / "berlin-photos");
  EXPECT_TRUE(photos.albedos_assumed);
  EXPECT_EQ(photos.frames.size(), 3u);
  EXPECT_EQ(photos.frames[0].sample_polygons.size(), 8u);
}

}  // namespace
}  // namespace pleinair::sequence_test
