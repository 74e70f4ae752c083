#include "calib/response.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scene/srgb.h"
#include "tests/calib/linear_from_code.h"

namespace pleinair::response_test {
namespace {

class ResponseFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const nlohmann::json& document) {
    const std::filesystem::path file = folder_ / "response.json";
    std::ofstream(file) << document.dump();
    return file;
  }
  std::string Refusal(const nlohmann::json& document) {
    try {
      ResponseCurve::FromFile(Write(document));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

glm::u8vec3 Codes(int red, int green, int blue) {
  return {static_cast<std::uint8_t>(red),
          static_cast<std::uint8_t>(green),
          static_cast<std::uint8_t>(blue)};
}

nlohmann::json GammaDocument(double gamma) {
  nlohmann::json list = nlohmann::json::array();
  for (int code = 0; code < 256; ++code) list.push_back(std::pow(code / 255.0, gamma));
  return {
      {"format", "pleinair-response"}, {"version", 1}, {"linear_of_code_rgb", {list, list, list}}};
}

// IEC 61966-2-1: code 128 is 0.2158605 linear; the linear part ends at 0.0031308 <-> 0.04045.
TEST(ResponseCurve, IsTheStandardForSrgb) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  EXPECT_NEAR(LinearFromCode(srgb, {128, 0, 255}).x, 0.2158605, 1e-6);
  EXPECT_EQ(LinearFromCode(srgb, {128, 0, 255}).y, 0.0f);
  EXPECT_EQ(LinearFromCode(srgb, {128, 0, 255}).z, 1.0f);
  EXPECT_NEAR(SrgbFromLinear(0.0031308), 0.04045, 1e-5);
  for (double x = 0.0; x <= 2.0; x += 0.01) EXPECT_NEAR(LinearFromSrgb(SrgbFromLinear(x)), x, 1e-7);
}

TEST(ResponseCurve, GivesEveryCodeBack) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  for (int code = 0; code < 256; ++code) {
    const glm::u8vec3 codes = Codes(code, 255 - code, code / 2);
    EXPECT_EQ(srgb.CodeFromLinear(LinearFromCode(srgb, codes)), codes);
  }
}

// The second way: rounding the encoded value. They may differ only where float does not
// resolve the half, which these odd steps do not meet.
TEST(ResponseCurve, RoundsToTheNearestCode) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  for (double linear = 0.00013; linear < 1.0; linear += 0.000737) {
    const auto expected = static_cast<int>(std::lround(255.0 * SrgbFromLinear(linear)));
    EXPECT_EQ(srgb.CodeFromLinear(glm::vec3(static_cast<float>(linear))).x, expected) << linear;
  }
}

TEST(ResponseCurve, ClipsAsACameraDoes) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(srgb.CodeFromLinear({-1.0f, 7.0f, infinity}), glm::u8vec3(0, 255, 255));
  EXPECT_EQ(srgb.CodeFromLinear({std::nanf(""), -infinity, 1.0f}), glm::u8vec3(0, 0, 255));
}

TEST(ResponseCurve, TurnsPicturesIntoRadianceAndBack) {
  Rgb8Image codes(16, 16);
  for (int i = 0; i < 256; ++i) codes.pixels[i] = Codes(i, i, 255 - i);
  const RgbImage radiance = RadianceFromCodes(codes, ResponseCurve::Srgb(), 0.004);
  EXPECT_NEAR(radiance.pixels[255].x, 250.0f, 1e-4f);
  EXPECT_EQ(CodesFromRadiance(radiance, ResponseCurve::Srgb(), 0.004).pixels, codes.pixels);
  EXPECT_THROW(RadianceFromCodes(codes, ResponseCurve::Srgb(), 0.0), std::invalid_argument);
  EXPECT_THROW(CodesFromRadiance(radiance, ResponseCurve::Srgb(), std::nan("")),
               std::invalid_argument);
}

TEST_F(ResponseFile, IsReadAndInverted) {
  const ResponseCurve curve = ResponseCurve::FromFile(Write(GammaDocument(2.0)));
  EXPECT_NEAR(LinearFromCode(curve, {51, 102, 255}).y, 0.16f, 1e-6f);
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(curve.CodeFromLinear(LinearFromCode(curve, Codes(code, code, code))),
              Codes(code, code, code));
  }
}

TEST_F(ResponseFile, WithFlatEndsComesBackAsTheSameLight) {
  nlohmann::json document = GammaDocument(1.0);
  for (auto& list : document["linear_of_code_rgb"]) {
    for (int code = 0; code < 256; ++code) {
      list[code] = std::clamp((code - 10) / 200.0, 0.0, 1.0);
    }
  }
  const ResponseCurve curve = ResponseCurve::FromFile(Write(document));
  for (int code = 0; code < 256; ++code) {
    const glm::vec3 linear = LinearFromCode(curve, Codes(code, code, code));
    EXPECT_EQ(LinearFromCode(curve, curve.CodeFromLinear(linear)), linear) << code;
  }
}

TEST_F(ResponseFile, IsRefusedByPlaceWhenItIsNoCurve) {
  nlohmann::json document = GammaDocument(2.0);
  document["linear_of_code_rgb"][1][7] = 0.9;
  EXPECT_NE(Refusal(document).find("linear_of_code_rgb[1][8]"), std::string::npos);
  document = GammaDocument(2.0);
  document["linear_of_code_rgb"][2].erase(0);
  EXPECT_NE(Refusal(document).find("linear_of_code_rgb[2]: expected a list of 256"),
            std::string::npos);
  document = GammaDocument(2.0);
  document["linear_of_code_rgb"][0] = std::vector<double>(256, 0.5);
  EXPECT_NE(Refusal(document).find("rise"), std::string::npos);
  document = GammaDocument(2.0);
  document["linear_of_code_rgb"][0][255] = 1.5;
  EXPECT_NE(Refusal(document).find("[255]: expected a number from 0.0 to 1.0, found 1.5"),
            std::string::npos);
  document = GammaDocument(2.0);
  document["version"] = 2;
  EXPECT_NE(Refusal(document).find("version"), std::string::npos);
  EXPECT_THROW(ResponseCurve::FromFile(folder_ / "absent.json"), std::runtime_error);
}

TEST_F(ResponseFile, IsWrittenAsItIsRead) {
  const ResponseCurve curve = ResponseCurve::FromFile(Write(GammaDocument(1.8)));
  const ResponseCurve again =
      ResponseCurve::FromFile(Write(nlohmann::json::parse(curve.FileText())));
  for (int c = 0; c < 3; ++c) EXPECT_EQ(again.LinearOfCode(c), curve.LinearOfCode(c));
}

TEST(ResponseTables, AreRefusedByChannelAndCode) {
  ResponseTable table{};
  for (auto& channel : table) {
    for (std::size_t code = 0; code < 256; ++code) {
      channel[code] = static_cast<float>(code) / 255.0f;
    }
  }
  EXPECT_NO_THROW(ResponseCurve::FromTable(table));
  for (const float bad : {0.0f, 2.0f, std::numeric_limits<float>::quiet_NaN()}) {
    ResponseTable broken = table;
    broken[1][200] = bad;
    try {
      ResponseCurve::FromTable(broken);
      FAIL() << bad << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("channel 1 at code 200"), std::string::npos);
    }
  }
  table[2].fill(0.5f);
  EXPECT_THROW(ResponseCurve::FromTable(table), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::response_test
