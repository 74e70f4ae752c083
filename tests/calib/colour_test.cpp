// Tying cameras in colour, and the chart that helps with it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/colour_chart.h"
#include "calib/colour_tie.h"
#include "calib/exif_exposure.h"
#include "calib/response.h"
#include "scene/image_io.h"

namespace pleinair::colour_test {
namespace {

const std::filesystem::path kData = std::filesystem::path(PLEINAIR_SHARED_DIR) / "data";

std::vector<ColourPair> Pairs(const glm::dmat3& matrix, int count, double noise) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.05, 1.0);
  std::normal_distribution<double> normal(1.0, noise);
  std::vector<ColourPair> pairs;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 from(unit(random), unit(random), unit(random));
    const glm::dvec3 to = matrix * from;
    pairs.push_back({from, to * glm::dvec3(normal(random), normal(random), normal(random))});
  }
  return pairs;
}

double WorstEntry(const glm::dmat3& a, const glm::dmat3& b) {
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) worst = std::max(worst, std::abs(a[c][r] - b[c][r]));
  }
  return worst;
}

const glm::dmat3 kScale(1.5, 0, 0, 0, 0.8, 0, 0, 0, 2.5);
const glm::dmat3 kMixing(1.2, 0.1, 0.02, 0.2, 0.9, 0.1, 0.05, 0.15, 1.4);

TEST(ColourTie, IsExactOnExactPairs) {
  EXPECT_LT(
      WorstEntry(FitColourTie(Pairs(kScale, 1, 0), ColourTieKind::kScale).to_from_rgb, kScale),
      1e-12);
  EXPECT_LT(
      WorstEntry(FitColourTie(Pairs(kScale, 20, 0), ColourTieKind::kScale).to_from_rgb, kScale),
      1e-12);
  const ColourTie tie = FitColourTie(Pairs(kMixing, 20, 0), ColourTieKind::kMatrix);
  EXPECT_LT(WorstEntry(tie.to_from_rgb, kMixing), 1e-12);
  EXPECT_LT(tie.rms_relative, 1e-12);
}

TEST(MeanOfDisc, IsThatOfAllPixelsWithinTheRadius) {
  RgbImage light(23, 17);
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) light.At(x, y) = glm::vec3(x, y, x * y);
  }
  int inside = 0;
  for (const glm::dvec2& centre : {glm::dvec2(11.0, 8.0),
                                   glm::dvec2(0.0, 0.0),
                                   glm::dvec2(22.4, 16.4),
                                   glm::dvec2(-3.5, 8.25),
                                   glm::dvec2(24.0, -2.0)}) {
    for (const double radius : {0.2, 1.0, 3.7, 6.0, 100.0}) {
      glm::dvec3 sum(0.0);
      int count = 0;
      for (int y = 0; y < light.height; ++y) {
        for (int x = 0; x < light.width; ++x) {
          if (glm::distance(glm::dvec2(x, y), centre) > std::max(radius, 0.5)) continue;
          sum += glm::dvec3(light.At(x, y));
          ++count;
        }
      }
      if (count == 0) {
        EXPECT_THROW(MeanOfDisc(light, centre, radius), std::invalid_argument);
        continue;
      }
      ++inside;
      EXPECT_EQ(MeanOfDisc(light, centre, radius), sum / static_cast<double>(count));
    }
  }
  EXPECT_GE(inside, 18);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double far : {1e300, -1e300, infinity, -infinity, std::nan("")}) {
    EXPECT_THROW(MeanOfDisc(light, {far, 3.0}, 2.0), std::invalid_argument);
    EXPECT_THROW(MeanOfDisc(light, {3.0, far}, 2.0), std::invalid_argument);
  }
}

// A fifth of the pairs are of something else; noise 1 % leaves each factor known to 1 % / sqrt(80),
// some three sigma.
TEST(ColourTie, StandsPairsThatDoNotFit) {
  for (const ColourTieKind kind : {ColourTieKind::kScale, ColourTieKind::kMatrix}) {
    const glm::dmat3 truth = kind == ColourTieKind::kScale ? kScale : kMixing;
    std::vector<ColourPair> pairs = Pairs(truth, 100, 0.01);
    for (std::size_t i = 0; i < 20; ++i) pairs[5 * i].to_rgb *= 1.5 + 0.1 * static_cast<double>(i);
    const ColourTie tie = FitColourTie(pairs, kind);
    EXPECT_LT(WorstEntry(tie.to_from_rgb, truth), kind == ColourTieKind::kScale ? 0.01 : 0.02);
    for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(tie.counts[i], i % 5 != 0) << i;
  }
}

TEST(ColourTie, ScalesWithTheLight) {
  std::vector<ColourPair> pairs = Pairs(kMixing, 30, 0.02);
  const glm::dmat3 found = FitColourTie(pairs, ColourTieKind::kMatrix).to_from_rgb;
  for (ColourPair& pair : pairs) pair.to_rgb *= 1e6;
  EXPECT_LT(WorstEntry(FitColourTie(pairs, ColourTieKind::kMatrix).to_from_rgb, found * 1e6), 1e-3);
}

TEST(ColourTie, RefusesWhatDeterminesNothing) {
  EXPECT_THROW(FitColourTie({}, ColourTieKind::kScale), std::invalid_argument);
  std::vector<ColourPair> pairs = Pairs(kScale, 5, 0);
  pairs[2].to_rgb.y = 0.0;
  EXPECT_THROW(FitColourTie(pairs, ColourTieKind::kScale), std::invalid_argument);
  for (const double value : {-1.0, 1e-200, 1e200, std::nan("")}) {
    pairs = Pairs(kScale, 5, 0);
    pairs[2].from_rgb.z = value;
    try {
      FitColourTie(pairs, ColourTieKind::kMatrix);
      FAIL() << value;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("colour pair 3: expected numbers from 1e-12"),
                std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(FitColourTie(Pairs(kScale, 2, 0), ColourTieKind::kMatrix), std::runtime_error);
  std::vector<ColourPair> greys;
  for (double grey = 0.1; grey < 1.0; grey += 0.1)
    greys.push_back({glm::dvec3(grey), glm::dvec3(grey)});
  EXPECT_THROW(FitColourTie(greys, ColourTieKind::kMatrix), std::runtime_error);
  EXPECT_NO_THROW(FitColourTie(greys, ColourTieKind::kScale));
}

// A chart drawn upside down, each patch of its reflectance.
TEST(ColourChart, IsMeasuredAsItsCornersSay) {
  RgbImage picture(700, 500, glm::vec3(0.02f));
  for (int y = 0; y < 450; ++y) {
    for (int x = 0; x < 670; ++x) {
      const double u = (669 - x) / 40.0;
      const double v = (449 - y) / 40.0;
      const int column = static_cast<int>((u - 0.25) / 2.75);
      const int row = static_cast<int>((v - 0.25) / 2.75);
      if (u < 0.25 || v < 0.25 || u - 0.25 - 2.75 * column > 2.5 || v - 0.25 - 2.75 * row > 2.5) {
        continue;
      }
      picture.At(x, y) = glm::vec3(
          static_cast<float>(kChartReflectance[static_cast<std::size_t>(6 * row + column)]));
    }
  }
  const ChartCorners corners{{{669.5, 449.5}, {-0.5, 449.5}, {-0.5, -0.5}, {669.5, -0.5}}};
  const auto patches = MeasureChart(picture, corners);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_NEAR(patches[i].mean.y, kChartReflectance[i], 1e-6) << i;
    EXPECT_LT(patches[i].stddev.y, 1e-6);
  }
  EXPECT_THROW(MeasureChart(picture, {{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}),
               std::invalid_argument);
  EXPECT_THROW(MeasureChart(picture, {{{0, 0}, {800, 0}, {600, 400}, {0, 400}}}),
               std::invalid_argument);
  EXPECT_FALSE(FindColourChart(Rgb8Image(200, 200, glm::u8vec3(90))));
  EXPECT_FALSE(FindColourChart(Rgb8Image()));
}

// The published luminances against those of another published table (linear sRGB of a maker):
// within 0.01, which is what charts of different years differ by.
TEST(ColourChart, HasThePublishedReflectances) {
  const std::filesystem::path file = kData / "colorchecker/xrite_linear_sRGB.csv";
  std::ifstream stream(file);
  if (!stream) GTEST_SKIP() << "no table " << file;
  std::string line;
  for (const double reflectance : kChartReflectance) {
    ASSERT_TRUE(std::getline(stream, line));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    double r = 0.0;
    double g = 0.0;
    double b = 0.0;
    numbers >> r >> g >> b;
    EXPECT_NEAR(0.2126 * r + 0.7152 * g + 0.0722 * b, reflectance, 0.02) << line;
  }
}

// A real photograph, whose chart is small and upright: found, the white patch the brightest of all
// and the greys falling in order.
TEST(ColourChart, IsFoundInAPhotograph) {
  const std::filesystem::path file = kData / "colorchecker/chart_photo_1.jpg";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no picture " << file;
  const Rgb8Image picture = ReadDisplayImage(file);
  const auto corners = FindColourChart(picture);
  ASSERT_TRUE(corners);
  const auto patches = MeasureChart(picture, *corners);
  for (std::size_t i = 0; i < 24; ++i) EXPECT_LE(patches[i].mean.y, patches[18].mean.y) << i;
  for (std::size_t i = 19; i < 24; ++i) EXPECT_LT(patches[i].mean.y, patches[i - 1].mean.y - 5.0);
  // Red is red, green green, blue blue.
  EXPECT_GT(patches[14].mean.x, 1.5 * patches[14].mean.y);
  EXPECT_GT(patches[13].mean.y, 1.5 * patches[13].mean.x);
  EXPECT_GT(patches[12].mean.z, 1.5 * patches[12].mean.x);
}

TEST(ExifExposure, IsReadFromPhotographs) {
  const std::filesystem::path folder = kData / "brackets/office_fisheye";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no pictures in " << folder;
  const ExifExposure exposure = ReadExifExposure(folder / "IMG_6964.jpg");
  EXPECT_EQ(exposure.exposure_s, 0.025);
  EXPECT_EQ(exposure.iso, 100.0);
  EXPECT_EQ(exposure.f_number, 5.6);
  EXPECT_NEAR(exposure.RelativeExposure().value(), 0.025 * 100.0 / (5.6 * 5.6), 1e-12);
  EXPECT_FALSE(ReadExifExposure(folder / "merged_reference.hdr").RelativeExposure());
  EXPECT_FALSE(ReadExifExposure(folder / "absent.jpg").RelativeExposure());
}

}  // namespace
}  // namespace pleinair::colour_test
