#include "apps/irradiance_command.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pleinair::irradiance_command_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A folder with a square of ground 20 m wide, albedo 0.5, and a file of two points.
class IrradianceCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("pleinair_irradiance_" + std::to_string(getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
    Write("ground.obj",
          "mtllib ground.mtl\nusemtl grey\nv -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\n"
          "f 1 2 3 4\n");
    Write("ground.mtl", "newmtl grey\nKd 0.5 0.5 0.5\n");
    Write("points.json", R"({"points": [[0, 0, 0.1], [1, 2, 0.1]],
                             "normals": [[0, 0, 1], [0, 0, -1], [1, 0, 0]]})");
    options_.scene = folder_ / "ground.obj";
    options_.points = folder_ / "points.json";
    options_.out = folder_ / "out.json";
    options_.cache = folder_ / "cache";
    options_.gather.rays_per_point = 1024;
    options_.gather.sky_rays_per_point = 8192;
    options_.gather.sky_rays_per_patch = 1024;
    options_.gather.rays_per_patch = 64;
    options_.gather.patch_size_m = 1.0;
  }
  void TearDown() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  nlohmann::json Run() const {
    RunIrradianceCommand(options_);
    std::ifstream out(options_.out);
    return nlohmann::json::parse(out);
  }
  std::string Error() const {
    try {
      RunIrradianceCommand(options_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
  IrradianceCommandOptions options_;
};

// Up: pi straight, 0 from the ground. Down: 0 straight, and albedo pi by way of the ground (whose
// border the point sees at 10 m from 0.1 m: 1e-4 is missing). 1 % for the rays.
TEST_F(IrradianceCommand, GivesTheClosedFormOverOpenGround) {
  options_.uniform_sky = true;
  const nlohmann::json out = Run();
  for (const nlohmann::json& of_point : out.at("irradiance")) {
    EXPECT_NEAR(of_point.at(0).at(0).at(0), std::numbers::pi, 0.03);
    EXPECT_NEAR(of_point.at(1).at(0).at(1), 0.5 * std::numbers::pi, 0.02);
    // A wall: half the sky, and half the ground's light.
    EXPECT_NEAR(of_point.at(2).at(0).at(2), (0.5 + 0.25) * std::numbers::pi, 0.04);
  }
  EXPECT_EQ(out.at("points").size(), 2u);
  EXPECT_EQ(out.at("part"), "total");
}

TEST_F(IrradianceCommand, WritesRegionsInTheStatedOrder) {
  options_.sky_regions = "2x4";
  options_.light = LightPart::kDirect;
  const nlohmann::json east = Run().at("irradiance").at(0).at(2);
  ASSERT_EQ(east.size(), 8u);
  // Sector 0 is from north to east, sector 3 from west to north; a plane that faces east sees the
  // first two of a band alone.
  for (const std::size_t region : {0u, 1u, 4u, 5u}) EXPECT_GT(east.at(region).at(0), 0.1) << region;
  for (const std::size_t region : {2u, 3u, 6u, 7u}) EXPECT_EQ(east.at(region).at(0), 0.0) << region;
}

TEST_F(IrradianceCommand, ASunIsAUnitBeam) {
  options_.sun = "90,30";
  options_.light = LightPart::kDirect;
  const nlohmann::json of_point = Run().at("irradiance").at(0);
  EXPECT_NEAR(of_point.at(0).at(0).at(0), 0.5, 1e-4);
  EXPECT_NEAR(of_point.at(2).at(0).at(0), std::sqrt(0.75), 1e-4);
  EXPECT_EQ(of_point.at(1).at(0).at(0), 0.0);
}

TEST_F(IrradianceCommand, WritesNineCoefficients) {
  options_.spherical_harmonics = true;
  Write("points.json", R"({"points": [[0, 0, 1]]})");
  const nlohmann::json out = Run();
  ASSERT_EQ(out.at("coefficients").at(0).size(), 64u);
  EXPECT_EQ(out.at("coefficients").at(0).at(5).size(), 9u);
  EXPECT_FALSE(out.contains("irradiance"));
}

TEST_F(IrradianceCommand, RefusesInOneLineAndWritesNothing) {
  const auto refused = [&](const std::function<void()>& change, const std::string& word) {
    const IrradianceCommandOptions before = options_;
    change();
    EXPECT_THAT(Error(), HasSubstr(word));
    EXPECT_FALSE(fs::exists(options_.out)) << word;
    options_ = before;
  };
  refused([&] { options_.sky_regions = "4by16"; }, "--sky-regions '4by16'");
  refused([&] { options_.sky_regions = "0x16"; }, "0 bands");
  refused([&] { options_.sun = "10"; }, "--sun '10'");
  refused([&] { options_.sun = "10,91"; }, "elevation");
  refused([&] { options_.sun = "10,20", options_.uniform_sky = true; }, "expected one of");
  refused([&] { options_.scene.clear(); }, "--scene or --sequence");
  refused([&] { options_.sequence = folder_; }, "--scene or --sequence");
  refused([&] { options_.points = folder_ / "none.json"; }, "none.json");
  refused([&] { Write("points.json", R"({"points": [[0, 0]], "normals": [[0, 0, 1]]})"); },
          "points[0]");
  refused([&] { Write("points.json", R"({"points": [[0, 0, 0]], "normals": [[0, 0, 2]]})"); },
          "normals[0]");
  refused([&] { Write("points.json", R"({"points": [[0, 0, 0]]})"); }, "normals");
  refused([&] { Write("points.json", R"({"point": [[0, 0, 0]]})"); }, "point");
}

}  // namespace
}  // namespace pleinair::irradiance_command_test
