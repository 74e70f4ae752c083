#include "calib/colour_chart.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>

namespace pleinair {
namespace {

constexpr int kColumns = 6;
// OpenCV's model of the chart: patches of 2.5, 0.25 between them and around the field.
constexpr double kPitch = 2.75;
constexpr double kFirstCentre = 1.5;
constexpr double kPatchSide = 2.5;
constexpr double kFieldWidth = 16.75;
constexpr double kFieldHeight = 11.25;

double Cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// Inside the picture, and turning one way at every corner.
void RequireField(const ChartCorners& corners, int width, int height) {
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2& corner = corners[i];
    if (!(corner.x >= -0.5 && corner.y >= -0.5 && corner.x <= width - 0.5 &&
          corner.y <= height - 0.5)) {
      throw std::invalid_argument(std::string("chart corner ") + std::to_string(corner.x) + "," +
                                  std::to_string(corner.y) + ": expected a place in the picture, " +
                                  std::to_string(width) + "x" + std::to_string(height));
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2 edge = corners[(i + 1) % 4] - corners[i];
    const glm::dvec2 next = corners[(i + 2) % 4] - corners[(i + 1) % 4];
    const glm::dvec2 first = corners[1] - corners[0];
    const glm::dvec2 second = corners[2] - corners[1];
    if (!(Cross(edge, next) * Cross(first, second) > 0.0)) {
      throw std::invalid_argument(
          "chart corners: expected those of dark skin, bluish green, black and white, in this "
          "order");
    }
  }
}

template <typename Pixel>
std::array<ChartPatch, kChartPatches> Measure(const Image<Pixel>& image,
                                              const ChartCorners& corners) {
  RequireField(corners, image.width, image.height);
  std::array<cv::Point2f, 4> field{cv::Point2f(0, 0),
                                   cv::Point2f(kFieldWidth, 0),
                                   cv::Point2f(kFieldWidth, kFieldHeight),
                                   cv::Point2f(0, kFieldHeight)};
  std::array<cv::Point2f, 4> seen;
  for (std::size_t i = 0; i < 4; ++i) {
    seen[i] = cv::Point2f(static_cast<float>(corners[i].x), static_cast<float>(corners[i].y));
  }
  const cv::Matx33d picture_from_field = cv::getPerspectiveTransform(field.data(), seen.data());
  std::array<ChartPatch, kChartPatches> patches;
  // A grid over the inner half of each side; nearest pixels, so that nothing is blended in.
  constexpr int kGrid = 24;
  for (int patch = 0; patch < kChartPatches; ++patch) {
    const int patch_column = patch % kColumns;
    const int patch_row = patch / kColumns;
    const double centre_x = kFirstCentre + kPitch * patch_column;
    const double centre_y = kFirstCentre + kPitch * patch_row;
    glm::dvec3 sum(0.0);
    glm::dvec3 squares(0.0);
    for (int j = 0; j < kGrid; ++j) {
      for (int i = 0; i < kGrid; ++i) {
        const double x = centre_x + 0.5 * kPatchSide * ((i + 0.5) / kGrid - 0.5);
        const double y = centre_y + 0.5 * kPatchSide * ((j + 0.5) / kGrid - 0.5);
        const cv::Vec3d at = picture_from_field * cv::Vec3d(x, y, 1.0);
        const int column =
            std::clamp(static_cast<int>(std::lround(at[0] / at[2])), 0, image.width - 1);
        const int row =
            std::clamp(static_cast<int>(std::lround(at[1] / at[2])), 0, image.height - 1);
        const glm::dvec3 value(image.At(column, row));
        sum += value;
        squares += value * value;
      }
    }
    constexpr double kCount = kGrid * kGrid;
    ChartPatch& measured = patches[static_cast<std::size_t>(patch)];
    measured.mean = sum / kCount;
    for (int c = 0; c < 3; ++c) {
      measured.stddev[c] =
          std::sqrt(std::max(squares[c] / kCount - measured.mean[c] * measured.mean[c], 0.0));
    }
  }
  return patches;
}

std::vector<double> Ranks(const std::array<double, kChartPatches>& values) {
  std::vector<std::size_t> order(kChartPatches);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return values[a] < values[b];
  });
  std::vector<double> ranks(kChartPatches);
  for (std::size_t i = 0; i < order.size(); ++i) ranks[order[i]] = static_cast<double>(i);
  return ranks;
}

// Spearman's: indifferent to the camera's response.
double RankCorrelation(const std::array<ChartPatch, kChartPatches>& patches) {
  std::array<double, kChartPatches> seen{};
  for (std::size_t i = 0; i < kChartPatches; ++i) {
    seen[i] = glm::dot(patches[i].mean, glm::dvec3(0.2126, 0.7152, 0.0722));
  }
  const std::vector<double> a = Ranks(seen);
  const std::vector<double> b = Ranks(kChartReflectance);
  double squared = 0.0;
  for (std::size_t i = 0; i < kChartPatches; ++i) squared += (a[i] - b[i]) * (a[i] - b[i]);
  constexpr double kN = kChartPatches;
  return 1.0 - 6.0 * squared / (kN * (kN * kN - 1.0));
}

}  // namespace

std::optional<ChartCorners> FindColourChart(const Rgb8Image& picture) {
  if (picture.Empty()) return std::nullopt;
  const cv::Mat rgb(
      picture.height, picture.width, CV_8UC3, const_cast<glm::u8vec3*>(picture.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  const auto detector = cv::mcc::CCheckerDetector::create();
  if (!detector->process(bgr, cv::mcc::MCC24, 1)) return std::nullopt;
  const auto chart = detector->getBestColorChecker();
  if (!chart) return std::nullopt;
  const std::vector<cv::Point2f> box = chart->getBox();
  if (box.size() != 4) return std::nullopt;
  ChartCorners found;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f& corner = box[i];
    found[i] = {std::clamp<double>(corner.x, -0.5, picture.width - 0.5),
                std::clamp<double>(corner.y, -0.5, picture.height - 0.5)};
  }
  // Whichever corner the finder begins with.
  std::optional<ChartCorners> best;
  // Random orders of 24 have a deviation of 1 / sqrt(23) = 0.2.
  double best_correlation = 0.8;
  for (std::size_t turn = 0; turn < 4; ++turn) {
    ChartCorners turned;
    for (std::size_t i = 0; i < 4; ++i) turned[i] = found[(i + turn) % 4];
    try {
      const double correlation = RankCorrelation(MeasureChart(picture, turned));
      if (correlation > best_correlation) {
        best_correlation = correlation;
        best = turned;
      }
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // What was found is no field of patches.
    }
  }
  return best;
}

std::array<ChartPatch, kChartPatches> MeasureChart(const Rgb8Image& picture,
                                                   const ChartCorners& corners) {
  return Measure(picture, corners);
}

std::array<ChartPatch, kChartPatches> MeasureChart(const RgbImage& radiance,
                                                   const ChartCorners& corners) {
  return Measure(radiance, corners);
}

}  // namespace pleinair
