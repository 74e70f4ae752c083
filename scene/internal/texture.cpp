#include "scene/internal/texture.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>
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

std::optional<Rgb8Image> DecodeCodes(std::span<const std::byte> encoded) {
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
  Rgb8Image codes(decoded.cols, decoded.rows);
  for (int y = 0; y < decoded.rows; ++y) {
    const cv::Vec3b* row = decoded.ptr<cv::Vec3b>(y);
    for (int x = 0; x < decoded.cols; ++x) {
      codes.At(x, y) = glm::u8vec3(row[x][2], row[x][1], row[x][0]);
    }
  }
  return codes;
}

}  // namespace

std::optional<Texture> Texture::Decode(std::span<const std::byte> encoded, TextureScale scale) {
  std::optional<Rgb8Image> codes = DecodeCodes(encoded);
  if (!codes) return std::nullopt;
  Texture texture;
  texture.codes_ = std::move(*codes);
  for (std::size_t code = 0; code < texture.linear_of_code_.size(); ++code) {
    const double value = static_cast<double>(code) / 255.0;
    texture.linear_of_code_[code] =
        static_cast<float>(scale == TextureScale::kSrgb ? LinearFromSrgb(value) : value);
  }
  glm::dvec3 sum(0.0);
  for (const glm::u8vec3& code : texture.codes_.pixels) {
    for (int c = 0; c < 3; ++c) sum[c] += double{texture.linear_of_code_.at(code[c])};
  }
  texture.mean_ = glm::vec3(sum / static_cast<double>(texture.codes_.pixels.size()));
  return texture;
}

glm::vec3 Texture::TexelAt(const glm::dvec2& uv) const {
  const double u = uv.x - std::floor(uv.x);
  const double v = uv.y - std::floor(uv.y);
  const int x = std::clamp(static_cast<int>(u * Width()), 0, Width() - 1);
  const int y = std::clamp(static_cast<int>((1.0 - v) * Height()), 0, Height() - 1);
  const glm::u8vec3& code = codes_.At(x, y);
  return {linear_of_code_.at(code.r), linear_of_code_.at(code.g), linear_of_code_.at(code.b)};
}

glm::vec3 Texture::MeanOver(const std::array<glm::dvec2, 3>& corners_uv) const {
  const glm::dvec2 a = corners_uv[1] - corners_uv[0];
  const glm::dvec2 b = corners_uv[2] - corners_uv[0];
  const double texels = 0.5 * std::abs(a.x * b.y - a.y * b.x) * Width() * Height();
  if (!std::isfinite(texels) || !std::isfinite(corners_uv[0].x + corners_uv[0].y)) return mean_;
  // The middles of side^2 equal triangles.
  constexpr int kMostPerSide = 16;
  const int side =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(std::min(texels, 1e6)))), 1, kMostPerSide);
  glm::dvec3 sum(0.0);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; i + j < side; ++j) {
      const auto at = [&](double third) {
        return glm::dvec3(TexelAt(corners_uv[0] + (i + third) / side * a + (j + third) / side * b));
      };
      sum += at(1.0 / 3.0);
      if (i + j + 1 < side) sum += at(2.0 / 3.0);
    }
  }
  return glm::vec3(sum / static_cast<double>(side * side));
}

}  // namespace pleinair
