#include "datasets/structural_similarity.h"

#include <stdexcept>

#include <opencv2/core.hpp>
#include <opencv2/quality/qualityssim.hpp>

namespace pleinair {
namespace {

constexpr int kReach = 5;  // Half width of QualitySSIM's window.

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
  const cv::Rect seen = cv::Rect(inside.x - kReach,
                                 inside.y - kReach,
                                 inside.width + 2 * kReach,
                                 inside.height + 2 * kReach) &
                        picture;
  cv::Mat similarity;
  cv::quality::QualitySSIM::compute(LumaOf(codes, seen), LumaOf(reference_codes, seen), similarity);
  return cv::mean(similarity(inside - seen.tl()))[0];
}

}  // namespace pleinair
