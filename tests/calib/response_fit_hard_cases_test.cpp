#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "calib/bracket_fit.h"
#include "tests/calib/linear_from_code.h"
#include "tests/calib/synthetic_bracket.h"

namespace pleinair::response_fit_hard_cases_test {
namespace {

const std::vector<double> kStops{8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125};

// Rises from code to code, and the inverse of the curve after the curve is the identity.
void ExpectInvertible(const ResponseTable& table, const std::string& name) {
  const ResponseCurve curve = ResponseCurve::FromTable(table);
  for (int code = 0; code < 256; ++code) {
    const glm::u8vec3 codes(static_cast<std::uint8_t>(code));
    const glm::vec3 light = LinearFromCode(curve, codes);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(curve.CodeFromLinear(light)[c], code, 1) << name;
      if (code == 0) continue;
      const glm::u8vec3 below(static_cast<std::uint8_t>(code - 1));
      EXPECT_GT(light[c], LinearFromCode(curve, below)[c]) << name << " at code " << code;
    }
  }
}

TEST(ResponseHardCases, CurvesFromBracketsRiseAndAreInvertible) {
  const CodeOfLight flat_ends = [](double linear) {
    return std::clamp(300.0 * std::pow(linear, 0.5) - 20.0, 12.0, 240.0);
  };
  const CodeOfLight coarse = [](double linear) {
    return 16.0 * std::round(255.0 / 16.0 * std::pow(linear, 1.0 / 2.2));
  };
  const CodeOfLight knee = [](double linear) {
    return linear < 0.2 ? 1000.0 * linear : 200.0 + 68.75 * (linear - 0.2);
  };
  // Falls back by 8 codes between 0.3 and 0.4: no curve at all.
  const CodeOfLight falling = [](double linear) {
    const double code = 255.0 * std::sqrt(linear);
    return linear > 0.3 && linear < 0.4 ? code - 250.0 * (linear - 0.3) : code;
  };
  struct Case {
    const char* name;
    CodeOfLight camera;
    CameraNoise noise;
  };
  for (const Case& with : {Case{"flat ends", flat_ends, {}},
                           Case{"quantised to 16 levels", coarse, {}},
                           Case{"knee", knee, {}},
                           Case{"falling", falling, {}},
                           Case{"very noisy", GammaCamera(2.2), {200.0, 20.0}}}) {
    const ResponseFit fit =
        FitResponseFromBrackets(MakeBracket(with.camera, kStops, with.noise).pictures);
    ExpectInvertible(fit.table, with.name);
    for (const ResponseChannelFit& channel : fit.channels) {
      EXPECT_TRUE(std::isfinite(channel.rms_relative)) << with.name;
    }
  }
}

// Codes below 12 and above 240 never occur: there the curve says no light, and white.
TEST(ResponseHardCases, FlatEndsAreNoLightAndWhite) {
  const CodeOfLight flat_ends = [](double linear) {
    return std::clamp(228.0 * linear + 12.0, 12.0, 240.0);
  };
  const ResponseFit fit = FitResponseFromBrackets(MakeBracket(flat_ends, kStops).pictures);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_LT(fit.table[c][12], 1e-5f);
    EXPECT_GT(fit.table[c][240], 0.999f);
    for (std::size_t code = 20; code <= 236; code += 8) {
      const double expected = (static_cast<double>(code) - 12.0) / 228.0;
      EXPECT_NEAR(fit.table[c][code] / expected, 1.0, 0.03) << code;
    }
  }
}

TEST(ResponseHardCases, RefuseBracketsThatShowNoCurve) {
  const auto refusal = [](const std::vector<ExposedPicture>& pictures) -> std::string {
    try {
      FitResponseFromBrackets(pictures);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(refusal({}).find("one picture or more"), std::string::npos);
  const ExposedPicture grey{Rgb8Image(100, 100, glm::u8vec3(90)), 1.0};
  EXPECT_NE(refusal({grey}).find("two different exposures"), std::string::npos);
  EXPECT_NE(refusal({grey, grey}).find("two different exposures"), std::string::npos);
  ExposedPicture darker = grey;
  darker.exposure = 0.5;
  EXPECT_NE(refusal({grey, darker}).find("response of red"), std::string::npos);
  const ExposedPicture white{Rgb8Image(100, 100, glm::u8vec3(255)), 2.0};
  EXPECT_NE(refusal({grey, white}).find("response of red"), std::string::npos);
  ExposedPicture small{Rgb8Image(10, 100, glm::u8vec3(90)), 0.5};
  EXPECT_NE(refusal({grey, small}).find("picture 2: expected 100x100"), std::string::npos);
  // Far more than a stop of exposure apart: no pixel is unclipped in both.
  EXPECT_NE(refusal(MakeBracket(GammaCamera(1.0), {1000.0, 0.001}).pictures).find("response of"),
            std::string::npos);
}

TEST(ResponseHardCases, AnySequenceIsMadeToRise) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<double, 256> values{};
    for (double& value : values) value = std::pow(10.0, 8.0 * unit(random) - 4.0);
    if (trial % 4 == 1) values.fill(3.0);
    if (trial % 4 == 2) std::fill(values.begin() + 60, values.end(), 5.0);
    if (trial % 4 == 3) values[static_cast<std::size_t>(trial)] = std::nan("");
    const std::array<float, 256> rising = StrictlyRising(values);
    ExpectInvertible({rising, rising, rising}, "trial " + std::to_string(trial));
  }
  std::array<double, 256> nothing{};
  const std::array<float, 256> rising = StrictlyRising(nothing);
  ExpectInvertible({rising, rising, rising}, "no light at all");
}

// Least squares with order: pooling by hand.
TEST(ResponseHardCases, IsotonicRegressionPoolsWhatFalls) {
  EXPECT_EQ(IsotonicRegression(std::vector<double>{1, 3, 2, 4}, std::vector<double>{1, 1, 1, 1}),
            (std::vector<double>{1, 2.5, 2.5, 4}));
  EXPECT_EQ(IsotonicRegression(std::vector<double>{4, 3, 2}, std::vector<double>{2, 1, 1}),
            (std::vector<double>{3.25, 3.25, 3.25}));
  EXPECT_TRUE(IsotonicRegression({}, {}).empty());
}

TEST(ResponseHardCases, SamplesThatAreNoCurveAreRepairedOrRefused) {
  std::array<std::vector<ResponseSample>, 3> samples;
  samples.fill({{0.03, 20.0}, {0.2, 90.0}, {0.1, 100.0}, {0.9, 200.0}});
  const ResponseFit fit = FitMonotoneResponse(samples);
  ExpectInvertible(fit.table, "one fall");
  EXPECT_EQ(fit.channels[0].falls_repaired, 1);
  EXPECT_GT(fit.channels[0].rms_relative, 0.1);
  ExpectInvertible(FitLogarithmicResponse(samples).response.table, "logarithmic");

  const auto refusal = [&](const ResponseSample& sample) -> std::string {
    auto bad = samples;
    bad[1].push_back(sample);
    try {
      FitMonotoneResponse(bad);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(refusal({0.0, 100.0}).find("green sample: light"), std::string::npos);
  EXPECT_NE(refusal({std::nan(""), 100.0}).find("green sample: light"), std::string::npos);
  EXPECT_NE(refusal({0.5, 256.0}).find("green sample: code"), std::string::npos);
  samples[2].resize(2);
  EXPECT_THROW(FitMonotoneResponse(samples), std::invalid_argument);
  samples.fill({{0.9, 20.0}, {0.5, 90.0}, {0.1, 200.0}});
  EXPECT_THROW(FitMonotoneResponse(samples), std::invalid_argument);
  EXPECT_THROW(FitLogarithmicResponse(samples), std::runtime_error);
}

// One picture of another exposure than is stated, one of something else: both are named, and the
// curve is that of the others. A good bracket keeps all.
TEST(ResponseHardCases, PicturesThatContradictTheOthersAreNamed) {
  const SyntheticBracket good = MakeBracket(GammaCamera(2.2), kStops);
  for (const BracketPicture& picture : FitBracket(good.pictures).pictures) {
    EXPECT_EQ(picture.reason, "");
    EXPECT_LT(std::abs(picture.offset), 0.1);
  }
  std::vector<ExposedPicture> spoiled = good.pictures;
  spoiled[2].exposure *= 1.7;
  std::mt19937 random(4);
  std::shuffle(spoiled[5].codes.pixels.begin(), spoiled[5].codes.pixels.end(), random);
  const BracketFit fit = FitBracket(spoiled);
  for (std::size_t i = 0; i < spoiled.size(); ++i) {
    EXPECT_EQ(fit.pictures[i].reason.empty(), i != 2 && i != 5) << i << fit.pictures[i].reason;
  }
  EXPECT_NE(fit.pictures[2].reason.find("expected its exposure"), std::string::npos);
  std::vector<ExposedPicture> rest;
  for (std::size_t i = 0; i < spoiled.size(); ++i) {
    if (i != 2 && i != 5) rest.push_back(spoiled[i]);
  }
  EXPECT_EQ(fit.response.table, FitResponseFromBrackets(rest).table);
}

// Three pictures or fewer have nothing to be compared with; what they show is judged by their
// curve.
TEST(ResponseHardCases, ACurveOfUnrelatedPicturesIsInDoubt) {
  const SyntheticBracket good = MakeBracket(GammaCamera(2.2), {4.0, 1.0, 0.25});
  const BracketFit fit = FitBracket(good.pictures);
  for (const BracketPicture& picture : fit.pictures) EXPECT_FALSE(picture.is_compared);
  EXPECT_EQ(DoubtAbout(fit.response), "");
  const BracketFit of_all = FitBracket(MakeBracket(GammaCamera(2.2), kStops).pictures);
  for (const BracketPicture& picture : of_all.pictures) EXPECT_TRUE(picture.is_compared);
  EXPECT_EQ(DoubtAbout(of_all.response), "");

  std::vector<ExposedPicture> spoiled = good.pictures;
  std::reverse(spoiled[1].codes.pixels.begin(), spoiled[1].codes.pixels.end());
  EXPECT_NE(DoubtAbout(FitBracket(spoiled).response).find("off one curve"), std::string::npos);
}

// `black` codes are cut off from light^(1 / gamma).
ResponseFit FitOf(double gamma, double black) {
  ResponseFit fit;
  fit.channels.fill({3, 250, 0.01, 0});
  for (std::size_t code = 0; code < 256; ++code) {
    const double light =
        std::pow((static_cast<double>(code) + black + 1.0) / (256.0 + black), gamma);
    for (auto& channel : fit.table) channel[code] = static_cast<float>(light);
  }
  return fit;
}

TEST(ResponseHardCases, ACurveThatIsNearlyFlatIsInDoubt) {
  EXPECT_EQ(DoubtAbout(FitOf(1.0, 0.0)), "");
  EXPECT_EQ(DoubtAbout(FitOf(1.0, 40.0)), "");
  EXPECT_EQ(DoubtAbout(FitOf(2.2, 0.0)), "");
  // Code 10 is at 0.85 of white.
  EXPECT_NE(DoubtAbout(FitOf(0.05, 0.0)).find("nearly flat"), std::string::npos);
  ResponseFit rises_late = FitOf(2.2, 0.0);
  for (std::size_t code = 10; code < 150; ++code) {
    rises_late.table[2][code] = rises_late.table[2][150];
  }
  EXPECT_NE(DoubtAbout(rises_late).find("response of blue: the curve is nearly flat"),
            std::string::npos);
}

}  // namespace
}  // namespace pleinair::response_fit_hard_cases_test
