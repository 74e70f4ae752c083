#include "scene/internal/texture_decoding.h"

#include <exception>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "scene/internal/encoded_image.h"

namespace pleinair {
namespace {

// Null where it cannot be decoded.
cv::Mat DecodedTexels(std::span<const std::byte> encoded, bool with_alpha) {
  try {
    if (encoded.empty()) return {};
    if (encoded.front() == std::byte{0x89}) {
      CheckPng("texture", encoded);
    } else {
      CheckJpeg("texture", encoded);
    }
    std::vector<std::byte> bytes(encoded.begin(), encoded.end());
    const cv::Mat wrapped(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
    // Coordinates are the picture's own, whichever way its maker held the camera.
    constexpr int kColour = cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION;
    // Only as it is does an image keep its alpha; then 16 bits stay too.
    cv::Mat decoded = cv::imdecode(wrapped, with_alpha ? cv::IMREAD_UNCHANGED : kColour);
    if (with_alpha && decoded.depth() == CV_16U) decoded.convertTo(decoded, CV_8U, 1.0 / 257.0);
    if (with_alpha && decoded.type() != CV_8UC4) decoded = cv::imdecode(wrapped, kColour);
    return decoded;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

std::shared_ptr<const Texture> DecodeTexture(std::span<const std::byte> encoded, bool with_alpha) {
  const cv::Mat decoded = DecodedTexels(encoded, with_alpha);
  if (decoded.empty() || (decoded.type() != CV_8UC3 && decoded.type() != CV_8UC4)) return nullptr;
  Texture::Codes codes(decoded.cols, decoded.rows);
  const bool has_alpha = decoded.type() == CV_8UC4;
  const int channels = decoded.channels();
  for (int y = 0; y < decoded.rows; ++y) {
    const std::uint8_t* texel = decoded.ptr<std::uint8_t>(y);
    for (int x = 0; x < decoded.cols; ++x, texel += channels) {
      codes.At(x, y) =
          glm::u8vec4(texel[2], texel[1], texel[0], has_alpha ? texel[3] : std::uint8_t{255});
    }
  }
  return std::make_shared<const Texture>(std::move(codes));
}

std::optional<glm::vec3> MeanOfLinearImage(std::span<const std::byte> encoded) {
  const cv::Mat decoded = DecodedTexels(encoded, false);
  if (decoded.empty() || decoded.type() != CV_8UC3) return std::nullopt;
  const cv::Scalar mean = cv::mean(decoded);
  return glm::vec3(mean[2] / 255.0, mean[1] / 255.0, mean[0] / 255.0);
}

}  // namespace pleinair
