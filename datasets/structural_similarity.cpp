#include "datasets/structural_similarity.h"

#include <algorithm>
#include <stdexcept>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace pleinair {
namespace {

constexpr int kWindow = 11;
constexpr double kWindowSigma = 1.5;
constexpr double kMeanConstant = (0.01 * 255.0) * (0.01 * 255.0);
constexpr double kVarianceConstant = (0.03 * 255.0) * (0.03 * 255.0);

cv::Mat1d LumaOf(const Image<glm::dvec3>& codes, const cv::Rect& box) {
  cv::Mat1d luma(box.height, box.width);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const glm::dvec3& code = codes.At(box.x + x, box.y + y);
      luma(y, x) = 0.299 * code.x + 0.587 * code.y + 0.114 * code.z;
    }
  }
  return luma;
}

cv::Mat1d Windowed(const cv::Mat1d& image) {
  cv::Mat1d mean;
  cv::GaussianBlur(
      image, mean, {kWindow, kWindow}, kWindowSigma, kWindowSigma, cv::BORDER_REFLECT_101);
  return mean;
}

}  // namespace

double StructuralSimilarity(const Image<glm::dvec3>& codes,
                            const Image<glm::dvec3>& reference_codes,
                            const PixelBox& box) {
  const cv::Rect picture(0, 0, codes.width, codes.height);
  const cv::Rect inside(box.left, box.top, box.right - box.left, box.bottom - box.top);
  if (codes.width != reference_codes.width || codes.height != reference_codes.height ||
      box.Empty() || (inside & picture) != inside) {
    throw std::invalid_argument(
        "structural similarity: expected two pictures of one size that hold the box");
  }
  constexpr int kReach = kWindow / 2;
  const cv::Rect seen = cv::Rect(inside.x - kReach,
                                 inside.y - kReach,
                                 inside.width + 2 * kReach,
                                 inside.height + 2 * kReach) &
                        picture;
  const cv::Mat1d a = LumaOf(codes, seen);
  const cv::Mat1d b = LumaOf(reference_codes, seen);
  const cv::Mat1d mean_a = Windowed(a);
  const cv::Mat1d mean_b = Windowed(b);
  const cv::Mat1d mean_aa = Windowed(cv::Mat1d(a.mul(a)));
  const cv::Mat1d mean_bb = Windowed(cv::Mat1d(b.mul(b)));
  const cv::Mat1d mean_ab = Windowed(cv::Mat1d(a.mul(b)));
  double sum = 0.0;
  for (int y = inside.y - seen.y; y < inside.y - seen.y + inside.height; ++y) {
    for (int x = inside.x - seen.x; x < inside.x - seen.x + inside.width; ++x) {
      const double ma = mean_a(y, x);
      const double mb = mean_b(y, x);
      const double variances = mean_aa(y, x) - ma * ma + mean_bb(y, x) - mb * mb;
      const double covariance = mean_ab(y, x) - ma * mb;
      sum += (2.0 * ma * mb + kMeanConstant) * (2.0 * covariance + kVarianceConstant) /
             ((ma * ma + mb * mb + kMeanConstant) * (variances + kVarianceConstant));
    }
  }
  return sum / inside.area();
}

}  // namespace pleinair
