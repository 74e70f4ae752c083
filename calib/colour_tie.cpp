#include "calib/colour_tie.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

#include "calib/internal/residual_text.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Range of a colour's channel: within it, no product of the fit leaves the range of double.
constexpr double kLeastLight = 1e-12;
constexpr double kMostLight = 1e12;
// Below this the third colour is noise on the others.
constexpr double kLeastColourSpread = 0.01;

void RequireColours(std::span<const ColourPair> pairs) {
  if (pairs.empty()) throw std::invalid_argument("colour pairs: expected one or more");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (const glm::dvec3& colour : {pairs[i].from_rgb, pairs[i].to_rgb}) {
      for (int c = 0; c < 3; ++c) {
        if (colour[c] >= kLeastLight && colour[c] <= kMostLight) continue;
        std::ostringstream text;
        text << "colour pair " << i + 1 << ": expected numbers from " << kLeastLight << " to "
             << kMostLight << ", found " << colour[c];
        throw std::invalid_argument(text.str());
      }
    }
  }
}

glm::dmat3 FitScale(std::span<const ColourPair> pairs, const std::vector<double>& weights) {
  glm::dmat3 matrix(0.0);
  for (int c = 0; c < 3; ++c) {
    double from_from = 0.0;
    double from_to = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double weight = weights[i] / (pairs[i].to_rgb[c] * pairs[i].to_rgb[c]);
      from_from += weight * pairs[i].from_rgb[c] * pairs[i].from_rgb[c];
      from_to += weight * pairs[i].from_rgb[c] * pairs[i].to_rgb[c];
    }
    matrix[c][c] = from_to / from_from;
  }
  return matrix;
}

glm::dmat3 FitMatrix(std::span<const ColourPair> pairs, const std::vector<double>& weights) {
  // Never fewer rows than colours, so that three singular values are there.
  const int rows = std::max(3, static_cast<int>(pairs.size()));
  cv::Mat from = cv::Mat::zeros(rows, 3, CV_64F);
  cv::Mat to = cv::Mat::zeros(rows, 3, CV_64F);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double weight = std::sqrt(weights[i]) / glm::length(pairs[i].to_rgb);
    for (int c = 0; c < 3; ++c) {
      from.at<double>(static_cast<int>(i), c) = weight * pairs[i].from_rgb[c];
      to.at<double>(static_cast<int>(i), c) = weight * pairs[i].to_rgb[c];
    }
  }
  const cv::SVD svd(from);
  if (!(svd.w.at<double>(2) > kLeastColourSpread * svd.w.at<double>(0))) {
    throw std::runtime_error(
        "colour matrix: cannot be determined: expected pairs of three different hues or more (a "
        "scale "
        "for each channel needs only one pair)");
  }
  cv::Mat solved;  // from * solved = to.
  svd.backSubst(to, solved);
  glm::dmat3 matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[column][row] = solved.at<double>(column, row);
  }
  return matrix;
}

struct Span {
  int first = 0;
  int end = 0;
};

// All of a picture's rows or columns that may be so near. Written so that a centre that is not
// finite is not converted to int.
Span PixelsWithin(double centre, double radius, int size) {
  const double first = std::min<double>(size, std::max(0.0, std::ceil(centre - radius)));
  const double last = std::max(-1.0, std::min<double>(size - 1, std::floor(centre + radius)));
  return {static_cast<int>(first), static_cast<int>(last) + 1};
}

}  // namespace

ColourTie FitColourTie(std::span<const ColourPair> pairs, ColourTieKind kind) {
  RequireColours(pairs);
  ColourTie tie;
  std::vector<double> weights(pairs.size(), 1.0);
  double limit = 0.0;
  // Reweighting by 1 / residual goes over to Cauchy's weights at the median residual; 20 rounds are
  // far more than it takes to settle.
  for (int round = 0; round < 20; ++round) {
    tie.to_from_rgb =
        kind == ColourTieKind::kScale ? FitScale(pairs, weights) : FitMatrix(pairs, weights);
    tie.residual_relative.clear();
    for (const ColourPair& pair : pairs) {
      tie.residual_relative.push_back(glm::length(tie.to_from_rgb * pair.from_rgb - pair.to_rgb) /
                                      glm::length(pair.to_rgb));
    }
    // Rounding of the numbers themselves, where all pairs fit exactly.
    constexpr double kExact = 1e-9;
    const double median = std::max(UpperMedian(tie.residual_relative), kExact);
    limit = kOutlierRatio * median;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double share = tie.residual_relative[i] / (1.5 * median);
      weights[i] = 1.0 / (1.0 + share * share);
    }
  }
  const glm::dvec3 of_white = tie.to_from_rgb * glm::dvec3(1.0);
  if (!(std::min({of_white.x, of_white.y, of_white.z}) > 0.0)) {
    throw std::runtime_error(
        "colour matrix: the pairs give one that leaves a channel of white without light: expected "
        "pairs of lighter colours (a scale for each channel needs only one pair)");
  }
  double sum = 0.0;
  int count = 0;
  for (const double residual : tie.residual_relative) {
    tie.counts.push_back(residual <= limit);
    if (!tie.counts.back()) continue;
    sum += residual * residual;
    ++count;
  }
  tie.rms_relative = std::sqrt(sum / count);
  return tie;
}

std::string DoubtAbout(const ColourTie& tie) {
  if (tie.rms_relative <= kLargestCredibleTieRms) return {};
  return NumberText("the pairs contradict each other by %.0f %% (rms)", 100.0 * tie.rms_relative) +
         NumberText(": expected the same surfaces in the same light, at most %.0f %%",
                    100.0 * kLargestCredibleTieRms);
}

glm::dvec3 MeanOfDisc(const RgbImage& light, const glm::dvec2& centre_px, double radius_px) {
  const double radius = std::max(radius_px, 0.5);
  const Span rows = PixelsWithin(centre_px.y, radius, light.height);
  const Span columns = PixelsWithin(centre_px.x, radius, light.width);
  glm::dvec3 sum(0.0);
  int count = 0;
  for (int y = rows.first; y < rows.end; ++y) {
    for (int x = columns.first; x < columns.end; ++x) {
      if (!(glm::distance(glm::dvec2(x, y), centre_px) <= radius)) continue;
      const glm::dvec3 pixel(light.At(x, y));
      if (!std::isfinite(pixel.x + pixel.y + pixel.z)) continue;
      sum += pixel;
      ++count;
    }
  }
  if (count > 0) return sum / static_cast<double>(count);
  std::ostringstream text;
  text << "region at " << centre_px.x << "," << centre_px.y << ": expected a place in the picture, "
       << light.width << "x" << light.height;
  throw std::invalid_argument(text.str());
}

ResponseTable TiedResponse(const ResponseCurve& response, const glm::dvec3& factor_rgb) {
  const double largest = std::max({factor_rgb.x, factor_rgb.y, factor_rgb.z});
  ResponseTable table{};
  for (int c = 0; c < 3; ++c) {
    if (!(factor_rgb[c] > 0.0) || !std::isfinite(largest)) {
      throw std::invalid_argument("colour factor: expected a positive number, found " +
                                  std::to_string(factor_rgb[c]));
    }
    const auto& linear = response.LinearOfCode(c);
    for (std::size_t code = 0; code < linear.size(); ++code) {
      table[static_cast<std::size_t>(c)][code] =
          static_cast<float>(linear[code] * factor_rgb[c] / largest);
    }
  }
  return table;
}

}  // namespace pleinair
