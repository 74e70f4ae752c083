#include "scene/internal/texture_mean.h"

#include <array>
#include <cmath>
#include <exception>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "scene/internal/encoded_image.h"

namespace pleinair {
namespace {

// IEC 61966-2-1.
double LinearFromSrgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace

std::optional<glm::vec3> MeanLinearColour(std::span<const std::byte> encoded) {
  cv::Mat decoded;
  try {
    if (encoded.empty()) return std::nullopt;
    if (encoded.front() == std::byte{0x89}) {
      CheckPng("texture", encoded);
    } else {
      CheckJpeg("texture", encoded);
    }
    std::vector<std::byte> bytes(encoded.begin(), encoded.end());
    const cv::Mat wrapped(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
    decoded = cv::imdecode(wrapped, cv::IMREAD_COLOR);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  if (decoded.empty() || decoded.type() != CV_8UC3) return std::nullopt;

  std::array<double, 256> linear{};
  for (std::size_t code = 0; code < linear.size(); ++code) {
    linear[code] = LinearFromSrgb(static_cast<double>(code) / 255.0);
  }
  glm::dvec3 sum(0.0);
  for (int y = 0; y < decoded.rows; ++y) {
    const cv::Vec3b* row = decoded.ptr<cv::Vec3b>(y);
    for (int x = 0; x < decoded.cols; ++x) {
      sum += glm::dvec3(linear[row[x][2]], linear[row[x][1]], linear[row[x][0]]);
    }
  }
  return glm::vec3(sum / static_cast<double>(decoded.total()));
}

}  // namespace pleinair
