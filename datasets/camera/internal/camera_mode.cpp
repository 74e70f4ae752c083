#include "datasets/camera/internal/camera_mode.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

namespace pleinair {
namespace {

// The earlier, the better a picture in the format is: what is lost in it, then what it costs.
int RankOf(const PixelFormat& format) {
  switch (format.coding) {
    case PixelCoding::kRgb:
      return 0;
    case PixelCoding::kYuyv:
      return 1;
    case PixelCoding::kNv12:
      return 2;
    case PixelCoding::kMjpeg:
      return 3;
    case PixelCoding::kBayer:  // Its colours are not balanced: for callers that ask for it.
      return 4;
    case PixelCoding::kGrey:
      break;
  }
  return 5;
}

}  // namespace

CameraMode ChooseMode(const std::string& device,
                      const std::vector<CameraMode>& modes,
                      const CameraRequest& request) {
  if (modes.empty()) {
    throw std::runtime_error(device + ": expected a camera with a format that can be decoded");
  }
  const auto cost = [&](const CameraMode& mode) {
    const bool other_format = request.format && !(mode.format == *request.format);
    const int width = request.width_px.value_or(640);
    const int height = request.height_px.value_or(request.width_px ? 0 : 480);
    const double stretch = height > 0
                               ? std::abs(std::log(static_cast<double>(mode.width_px) * height /
                                                   (static_cast<double>(mode.height_px) * width)))
                               : 0.0;
    const double scale = std::abs(std::log(static_cast<double>(mode.width_px) / width));
    const double wanted = request.frames_per_second.value_or(kUsualFramesPerSecond);
    const double rate = mode.frames_per_second.empty() ? wanted : mode.frames_per_second.front();
    // A rate that is short by a per cent is the same: 29.97.
    const double slower = std::max(wanted / rate - 1.01, 0.0);
    return std::tuple(
        other_format, std::round(100.0 * stretch), scale, slower, RankOf(mode.format));
  };
  const CameraMode& best =
      *std::min_element(modes.begin(), modes.end(), [&](const CameraMode& a, const CameraMode& b) {
        return cost(a) < cost(b);
      });
  if (request.format && !(best.format == *request.format)) {
    throw std::runtime_error(fmt::format(
        "{}: expected a camera with the format {}, it has none", device, NameOf(*request.format)));
  }
  return best;
}

}  // namespace pleinair
