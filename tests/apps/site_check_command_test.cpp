#include "apps/site_check_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_check_command_test {
namespace {

using testing::HasSubstr;

SiteCheckOptions Courtyard() {
  SiteCheckOptions options;
  options.session.sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  options.step_min = 240;
  // Coarse: no figure of the light is compared.
  options.session.prepare.patch_size_m = 4.0;
  options.session.prepare.rays = 64;
  return options;
}

TEST(SiteCheck, ReportsAGoodSitesHoursAsTextPictureAndJson) {
  const TemporaryFolder folder;
  SiteCheckOptions options = Courtyard();
  options.session.cache = folder / "cache";
  options.out = folder / "out";
  bool is_good = false;
  const std::string text = RunSiteCheck(options, &is_good);
  EXPECT_TRUE(is_good);
  EXPECT_THAT(text, HasSubstr("nothing is found to be wrong"));
  EXPECT_THAT(text, HasSubstr("clear sky of 2005-06-21"));  // The first frame's day.
  const Rgb8Image picture = ReadDisplayImage(folder / "out/day.png");
  EXPECT_GT(picture.width, 500);

  options.out = folder.Write("taken", "not a folder");
  EXPECT_THAT(MessageOf([&] { RunSiteCheck(options, &is_good); }),
              HasSubstr("taken: expected a folder, or room for one: "));

  options.json = true;
  options.out.clear();
  options.day = "2005-12-21";
  const auto json = nlohmann::json::parse(RunSiteCheck(options, &is_good));
  EXPECT_EQ(json.at("day"), "2005-12-21");
  ASSERT_FALSE(json.at("hours").empty());
  for (const auto& hour : json.at("hours")) {
    if (hour.at("sun_elevation_deg") <= 0.0) continue;  // Its limb alone is up.
    EXPECT_GT(hour.at("sun_relative_stddev").get<double>(), 0.0);
    EXPECT_LE(hour.at("lit_share").get<double>() + hour.at("shaded_share").get<double>(), 1.0);
  }
}

// A mesh in centimetres: said, and no hours of another place.
TEST(SiteCheck, GivesNoHoursOfAMeshThatIsNotThePlace) {
  const TemporaryFolder folder;
  std::filesystem::copy(
      Courtyard().session.sequence, folder.Path(), std::filesystem::copy_options::recursive);
  auto document = nlohmann::json::parse(ContentOf(folder / "sequence.json"));
  for (auto& row : document["camera"]["camera_from_world"]) row[3] = 300.0 * row[3].get<double>();
  document["camera"]["camera_from_world"][3][3] = 1.0;
  document["frames"] = nlohmann::json::array({document["frames"][0]});
  folder.Write("sequence.json", document.dump());
  SiteCheckOptions options = Courtyard();
  options.session.sequence = folder.Path();
  bool is_good = true;
  const std::string text = RunSiteCheck(options, &is_good);
  EXPECT_FALSE(is_good);
  EXPECT_THAT(text, HasSubstr("warning: the camera"));
  EXPECT_THAT(text, HasSubstr("no hours: first correct"));
}

TEST(SiteCheck, RefusesADayThatIsNone) {
  SiteCheckOptions options = Courtyard();
  options.day = "tomorrow";
  bool is_good = false;
  EXPECT_THAT([&] { RunSiteCheck(options, &is_good); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("--day tomorrow")));
}

}  // namespace
}  // namespace pleinair::site_check_command_test
