// Where the sun of a sequence is that states no place, and what is said of one stated wrongly.
#include "session/sequence_site.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "pipeline/sun_state.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "session/survey_map_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "sunmodel/time_text.h"
#include "tests/session/command_folder.h"

namespace pleinair::sequence_site_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr LatLongSize kSize{512, 256};
const Site kAalborg{0.99569, 0.17317, 15.0};
constexpr const char* kMorning = "2005-06-21T09:50:00Z";

glm::dvec3 TrueSun() { return SunOverSite(kAalborg, ParseUtcTime(kMorning)).direction_enu; }

// A plane of ground under an even sky, photographed twice.
class SequenceSiteTest : public CommandFolder {
 protected:
  void SetUp() override {
    CommandFolder::SetUp();
    Write("ground.obj", "o ground\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n");
    document_ = nlohmann::json::parse(R"({
      "format": "pleinair-sequence", "version": 1, "scene": {"mesh": "ground.obj"},
      "camera": {"width": 8, "height": 6, "fx": 10, "fy": 10, "cx": 3.5, "cy": 2.5,
        "camera_from_world": [[1, 0, 0, 0], [0, 0, -1, 1.6], [0, 1, 0, 0], [0, 0, 0, 1]]},
      "environment": {"image": "map.exr", "position_m": [0, 0, 1.6],
        "time_utc": "2005-06-21T09:50:00Z"},
      "frames": [{"image": "a.exr", "time_utc": "2005-06-21T09:50:00Z"},
                 {"image": "b.exr", "time_utc": "2005-06-21T10:50:00Z"}]})");
    WriteMap(std::nullopt);
  }

  void WriteMap(std::optional<glm::dvec3> sun) {
    RgbImage map(kSize.width, kSize.height, glm::vec3(1.0f));
    if (sun) {
      const glm::ivec2 at = LatLongPixelFromDirection(*sun, kSize);
      map.At(at.x, at.y) = glm::vec3(15.0f / float(LatLongPixelSolidAngleSr(at.y, kSize)));
    }
    WriteExr(folder_ / "map.exr", map, ExrPrecision::kFloat);
  }
  void SetSite() {
    document_["site"] = {{"latitude_deg", DegFromRad(kAalborg.latitude_rad)},
                         {"longitude_deg", DegFromRad(kAalborg.longitude_rad)},
                         {"height_m", kAalborg.height_m}};
  }
  Sequence Read() {
    Write("sequence.json", document_.dump());
    return ReadSequence(folder_);
  }
  // What is noted of the map in loading.
  std::vector<std::string> Notes() { return LoadSequenceSite(Read()).notes; }

  nlohmann::json document_;
};

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

// A pixel is 0.7 deg.
TEST_F(SequenceSiteTest, TakesTheSunFromTheMapForAllFramesThatStateNone) {
  WriteMap(TrueSun());
  const glm::dvec3 own(0.0, -0.6, 0.8);
  document_["frames"][1]["sun_direction_enu"] = {own.x, own.y, own.z};
  Sequence sequence = Read();
  EXPECT_THAT(FindSunInMap(sequence), ElementsAre(AllOf(HasSubstr("map.exr"), HasSubstr("disc"))));
  EXPECT_LT(AngleDeg(sequence.StatedSunDirectionEnu(0).value(), TrueSun()), 0.7);
  EXPECT_EQ(sequence.StatedSunDirectionEnu(1), own);
  EXPECT_FALSE(sequence.WeatherOfFrame(0));
  const SequenceSite site = LoadSequenceSite(sequence);
  // Made unit once more: a rounding.
  EXPECT_LT(glm::distance(site.model.environment->sun_direction_enu,
                          sequence.StatedSunDirectionEnu(0).value()),
            1e-15);
}

TEST_F(SequenceSiteTest, RunsWithoutASunWhereTheMapShowsNone) {
  Sequence sequence = Read();
  EXPECT_THAT(FindSunInMap(sequence), ElementsAre(HasSubstr("no sun in the map")));
  EXPECT_EQ(sequence.StatedSunDirectionEnu(0), kNoSunDirectionEnu);
  EXPECT_EQ(sequence.WeatherOfFrame(1), Weather::kOvercast);
  EXPECT_EQ(LoadSequenceSite(sequence).model.environment->sun_direction_enu, kNoSunDirectionEnu);
}

TEST_F(SequenceSiteTest, AsksForTheSunOfAClearFrameUnderAMapWithoutOne) {
  document_["frames"][1]["weather"] = "clear";
  Sequence sequence = Read();
  EXPECT_THAT(
      [&] { FindSunInMap(sequence); },
      ThrowsMessage<std::runtime_error>(HasSubstr("frames[1].sun_direction_enu: expected")));
}

TEST_F(SequenceSiteTest, LeavesAStatedSunAndAPlaceAlone) {
  WriteMap(TrueSun());
  SetSite();
  Sequence placed = Read();
  EXPECT_THAT(FindSunInMap(placed), IsEmpty());
  EXPECT_FALSE(placed.StatedSunDirectionEnu(0));
  document_.erase("site");
  document_["environment"]["sun_direction_enu"] = {0.0, -0.6, 0.8};
  Sequence stated = Read();
  EXPECT_THAT(FindSunInMap(stated), IsEmpty());
  EXPECT_EQ(stated.StatedSunDirectionEnu(0), glm::dvec3(0.0, -0.6, 0.8));
}

// Turned about the vertical by 1 deg (of the azimuth: 0.6 deg between directions), 5, 20 and 180.
TEST_F(SequenceSiteTest, WarnsWhereTheMapShowsTheSunElsewhere) {
  for (const bool stated : {false, true}) {
    stated ? void(document_["environment"]["sun_direction_enu"] = {TrueSun().x,
                                                                   TrueSun().y,
                                                                   TrueSun().z})
           : SetSite();
    for (const double turn_deg : {0.0, 1.0, -1.0}) {
      WriteMap(TurnedClockwise(TrueSun(), RadFromDeg(turn_deg)));
      EXPECT_THAT(Notes(), IsEmpty()) << turn_deg;
    }
    for (const double turn_deg : {5.0, 7.0, -20.0, 180.0}) {
      const glm::dvec3 shown = TurnedClockwise(TrueSun(), RadFromDeg(turn_deg));
      WriteMap(shown);
      const std::vector<std::string> notes = Notes();
      ASSERT_EQ(notes.size(), 1u) << turn_deg;
      const std::string angle = "the map shows the sun ";
      ASSERT_THAT(notes[0], HasSubstr(angle));
      EXPECT_NEAR(std::stod(notes[0].substr(notes[0].find(angle) + angle.size())),
                  AngleDeg(shown, TrueSun()),
                  0.7);
      EXPECT_THAT(notes[0], HasSubstr(stated ? "environment.sun_direction_enu" : "time (zone)"));
      // The sun of a map that is turned a little lights it all the same.
      const SequenceSite site = LoadSequenceSite(Read());
      const bool is_near = AngleDeg(shown, TrueSun()) < 30.0;
      EXPECT_LT(
          AngleDeg(site.model.environment.value().sun_direction_enu, is_near ? shown : TrueSun()),
          1.0);
    }
  }
  WriteMap(std::nullopt);
  EXPECT_THAT(Notes(), IsEmpty()) << "clouds hide it";
}

// A time zone off by twelve hours.
TEST_F(SequenceSiteTest, WarnsOfANightThatTheMapShowsTheSunIn) {
  SetSite();
  document_["environment"]["time_utc"] = "2005-06-21T23:30:00Z";
  WriteMap(TrueSun());
  EXPECT_THAT(Notes(), ElementsAre(HasSubstr("the map shows the sun")));
}

// A model whose +Y points to true azimuth 6 deg: a map to true north is turned into its frame, and
// its mask with it, one in the model's frame is left.
TEST_F(SequenceSiteTest, TurnsAMapToTrueNorthAlongWithTheModel) {
  SetSite();
  document_["diffuse_mask"] = "mask.png";
  Rgb8Image mask(kSize.width, kSize.height, glm::u8vec3(0));
  const glm::dvec3 marked_enu = TurnedClockwise({0.0, 0.8, -0.6}, RadFromDeg(40.0));
  const glm::ivec2 marked = LatLongPixelFromDirection(marked_enu, kSize);
  for (int x = marked.x - 3; x <= marked.x + 3; ++x) mask.At(x, marked.y) = glm::u8vec3(255);
  WritePng(folder_ / "mask.png", mask);
  const double north_rad = RadFromDeg(6.0);
  const glm::dvec3 in_model = TurnedClockwise(TrueSun(), -north_rad);
  for (const bool to_true_north : {true, false}) {
    WriteMap(to_true_north ? TrueSun() : in_model);
    Sequence sequence = Read();
    sequence.site->model_north_azimuth_rad = north_rad;
    const SequenceSite site = LoadSequenceSite(sequence);
    const SurveyMap& map = site.model.environment.value();
    EXPECT_LT(AngleDeg(map.sun_direction_enu, in_model), 1e-6);
    const glm::ivec2 at = LatLongPixelFromDirection(in_model, kSize);
    float brightest = 0.0f;
    for (int x = at.x - 1; x <= at.x + 1; ++x) {
      brightest = std::max(brightest, map.radiance.At(x, at.y).x);
    }
    EXPECT_GT(brightest, 1000.0f) << "the disc is where the model has the sun";
    const glm::ivec2 mask_at = LatLongPixelFromDirection(
        to_true_north ? TurnedClockwise(marked_enu, -north_rad) : marked_enu, kSize);
    EXPECT_EQ(site.model.diffuse_mask->At(mask_at.x, mask_at.y), 255);
    EXPECT_EQ(site.notes.size(), to_true_north ? 1u : 0u);
  }
}

// Two stated deviations, where there is one.
TEST_F(SequenceSiteTest, ExpectsTheMapAsFarTurnedAsTheModelsNorthIsUncertain) {
  SetSite();
  const auto turned_deg = [&] {
    return DegFromRad(LoadSequenceSite(Read()).model.environment->misplacement.turned_rad);
  };
  EXPECT_EQ(turned_deg(), DegFromRad(Misplacement{}.turned_rad));
  document_["site"]["north_uncertain_deg"] = 3.0;
  EXPECT_NEAR(turned_deg(), 6.0, 1e-9);
  document_["site"]["north_uncertain_deg"] = 180.0;
  EXPECT_NEAR(turned_deg(), 20.0, 1e-9);
}

}  // namespace
}  // namespace pleinair::sequence_site_test
