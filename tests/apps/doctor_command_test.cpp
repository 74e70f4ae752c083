#include "apps/doctor_command.h"

#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pleinair::doctor_command_test {
namespace {

using ::testing::Contains;
using ::testing::StartsWith;

// What a machine has differs; that each thing is looked at and judged does not.
TEST(DoctorCommand, LooksAtAllThatARunNeeds) {
  bool all_well = false;
  const nlohmann::json report = nlohmann::json::parse(RunDoctorCommand(true, &all_well));
  EXPECT_EQ(report.at("all_well"), all_well);
  std::set<std::string> names;
  bool any_broken = false;
  for (const nlohmann::json& check : report.at("checks")) {
    names.insert(check.at("name"));
    const std::string state = check.at("state");
    EXPECT_TRUE(state == "ok" || state == "missing" || state == "broken") << state;
    EXPECT_NE(check.at("found"), "");
    EXPECT_EQ(check.at("advice").get<std::string>().empty(), state == "ok") << check;
    any_broken = any_broken || state == "broken";
  }
  EXPECT_EQ(all_well, !any_broken);
  for (const char* name :
       {"pleinair", "OpenGL 4.5",     "OpenGL ES 3.1", "processor", "clock",        "cache",
        "gnuplot",  "magnetic model", "geoid",         "Embree",    "OpenCV",       "Ceres",
        "assimp",   "OpenEXR",        "ERFA",          "libcamera", "video output", "FFV1",
        "H.264",    "space",          "GeographicLib"}) {
    EXPECT_THAT(names, Contains(name));
  }
  EXPECT_THAT(names, Contains(StartsWith("camera")));
}

TEST(DoctorCommand, WritesOneJudgedLineForEachThing) {
  bool all_well = false;
  const std::size_t checks =
      nlohmann::json::parse(RunDoctorCommand(true, &all_well)).at("checks").size();
  std::istringstream text(RunDoctorCommand(false, &all_well));
  std::size_t lines = 0;
  for (std::string line; std::getline(text, line); ++lines) {
    EXPECT_TRUE(line.starts_with("ok ") || line.starts_with("missing ") ||
                line.starts_with("broken "))
        << line;
  }
  EXPECT_EQ(lines, checks);
}

}  // namespace
}  // namespace pleinair::doctor_command_test
