#include "calib/response_fit.h"

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>

#include "scene/image_io.h"
#include "tests/calib/linear_from_code.h"
#include "tests/calib/synthetic_bracket.h"

namespace pleinair::response_fit_test {
namespace {

const std::vector<double> kStops{8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625};

// Light at each code from 16 on (below, a pixel's noise is a third of its light) relative to that
// at code 128, against the camera's own.
void ExpectCurve(const ResponseFit& fit, double gamma, double tolerance) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t code = 16; code <= 250; ++code) {
      const double expected = std::pow(static_cast<double>(code) / 128.0, gamma);
      const double found = fit.table[c][code] / fit.table[c][128];
      EXPECT_NEAR(found / expected, 1.0, tolerance) << "gamma " << gamma << " code " << code;
    }
    EXPECT_EQ(fit.table[c][255], 1.0f);
    EXPECT_LE(fit.channels[c].lowest_code, 6);
    EXPECT_GE(fit.channels[c].highest_code, 252);
    EXPECT_LT(fit.channels[c].rms_relative, 0.03);
  }
}

// Rounding and noise average out over thousands of pixels; what is left is the smoothness: 2 %.
TEST(ResponseFromBrackets, FindsTheCamerasCurve) {
  for (const double gamma : {1.0, 2.2}) {
    ExpectCurve(
        FitResponseFromBrackets(MakeBracket(GammaCamera(gamma), kStops).pictures), gamma, 0.02);
  }
}

// A tenth of the scene is somewhere else in each picture: medians move by at most a ninth of the
// pixels' scatter, which is 0.7 of the light in the dark end: 0.08, and the smoothness as above.
TEST(ResponseFromBrackets, StandsThingsThatMove) {
  SyntheticBracket bracket = MakeBracket(GammaCamera(2.2), kStops);
  for (std::size_t k = 0; k < bracket.pictures.size(); ++k) {
    Rgb8Image& codes = bracket.pictures[k].codes;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < codes.width; ++x) {
        codes.At(x, y) = codes.At((x + 37 * static_cast<int>(k + 1)) % codes.width, 100 + y);
      }
    }
  }
  ExpectCurve(FitResponseFromBrackets(bracket.pictures), 2.2, 0.1);
}

TEST(ResponseFromBrackets, DoesNotDependOnTheirOrder) {
  SyntheticBracket bracket = MakeBracket(GammaCamera(1.8), kStops);
  const ResponseFit fit = FitResponseFromBrackets(bracket.pictures);
  std::swap(bracket.pictures[0], bracket.pictures[5]);
  std::swap(bracket.pictures[2], bracket.pictures[3]);
  EXPECT_EQ(FitResponseFromBrackets(bracket.pictures).table, fit.table);
}

// Real pictures of an office (13 s to 1/8000 s, nominal times). Neighbouring exposures differ in
// light by the ratio of their times: to 3 % in the median (nominal times are off by some per cent),
// where both pictures are well exposed. The response that came with them has -13 % / +7 %.
TEST(ResponseFromBrackets, ReproducesTheRatiosOfARealBracket) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/brackets/office_fisheye";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no pictures in " << folder;
  std::vector<ExposedPicture> pictures;
  double exposure_s = 0.8;
  for (int number = 6959; number <= 6966; ++number, exposure_s *= 0.5) {
    pictures.push_back(
        {ReadDisplayImage(folder / ("IMG_" + std::to_string(number) + ".jpg")), exposure_s});
  }
  const ResponseFit fit = FitResponseFromBrackets(pictures);
  const ResponseCurve curve = ResponseCurve::FromTable(fit.table);
  for (std::size_t k = 0; k + 1 < pictures.size(); ++k) {
    for (int c = 0; c < 3; ++c) {
      std::vector<double> ratios;
      for (std::size_t i = 0; i < pictures[k].codes.pixels.size(); i += 7) {
        const glm::u8vec3& bright = pictures[k].codes.pixels[i];
        const glm::u8vec3& dark = pictures[k + 1].codes.pixels[i];
        if (bright[c] < 50 || bright[c] > 230 || dark[c] < 20) continue;
        ratios.push_back(LinearFromCode(curve, bright)[c] / LinearFromCode(curve, dark)[c]);
      }
      ASSERT_GT(ratios.size(), 1000u);
      std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
      EXPECT_NEAR(ratios[ratios.size() / 2], 2.0, 2.0 * 0.03) << k << " " << c;
    }
  }
}

std::array<std::vector<ResponseSample>, 3> Samples(
    const std::function<double(double)>& code_of_light, const std::vector<double>& lights) {
  std::array<std::vector<ResponseSample>, 3> samples;
  for (const double light : lights) {
    for (auto& channel : samples) channel.push_back({light, code_of_light(light)});
  }
  return samples;
}

// The six greys of a ColorChecker at four illuminations: exact codes give the parameters back.
TEST(LogarithmicResponse, FindsItsThreeParameters) {
  std::vector<double> lights;
  for (const double illumination : {1.0, 30.0, 1000.0, 2e4}) {
    for (const double grey : {0.031, 0.09, 0.198, 0.362, 0.591, 0.9}) {
      lights.push_back(illumination * grey);
    }
  }
  const auto code = [](double light) { return 31.0 + 22.0 * std::log(0.4 + light); };
  const LogarithmicResponseFit fit = FitLogarithmicResponse(Samples(code, lights));
  for (const LogarithmicCurve& curve : fit.curves) {
    EXPECT_NEAR(curve.a, 31.0, 1e-3);
    EXPECT_NEAR(curve.b, 22.0, 1e-4);
    EXPECT_NEAR(curve.c, 0.4, 1e-4);
    EXPECT_LT(curve.rms_codes, 1e-4);
    EXPECT_NEAR(curve.LightFromCode(curve.CodeFromLight(123.0)), 123.0, 1e-8);
  }
  // The table's own scale: light relative to that of code 255.
  const double white = std::exp((255.0 - 31.0) / 22.0) - 0.4;
  for (std::size_t i = 30; i < 256; ++i) {
    const double light = std::exp((static_cast<double>(i) - 31.0) / 22.0) - 0.4;
    EXPECT_NEAR(fit.response.table[1][i], light / white, 1e-3 * light / white + 1e-6) << i;
  }
}

// Codes rounded to whole ones: half a code is 1 / (2 b) of the light, 2.3 %.
TEST(LogarithmicResponse, StandsRounding) {
  std::vector<double> lights;
  for (double light = 0.05; light < 2e4; light *= 1.9) lights.push_back(light);
  const auto code = [](double light) { return std::round(31.0 + 22.0 * std::log(0.4 + light)); };
  const LogarithmicResponseFit fit = FitLogarithmicResponse(Samples(code, lights));
  for (double light = 1.0; light < 2e4; light *= 3.0) {
    const double exact = 31.0 + 22.0 * std::log(0.4 + light);
    EXPECT_NEAR(fit.curves[0].LightFromCode(exact) / light, 1.0, 0.023);
  }
}

TEST(MonotoneResponse, GoesThroughItsSamplesByPowerLaws) {
  const auto code = [](double light) { return 255.0 * std::pow(light, 1.0 / 2.2); };
  const ResponseFit fit =
      FitMonotoneResponse(Samples(code, {0.031, 0.09, 0.198, 0.362, 0.591, 0.9}));
  for (std::size_t i = 5; i < 256; ++i) {
    const double expected = std::pow(static_cast<double>(i) / 255.0, 2.2);
    EXPECT_NEAR(fit.table[0][i] / expected, 1.0, 1e-3) << i;
  }
  EXPECT_LT(fit.channels[0].rms_relative, 1e-12);
}

}  // namespace
}  // namespace pleinair::response_fit_test
