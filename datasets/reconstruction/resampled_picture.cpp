#include "datasets/reconstruction/internal/resampled_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "calib/lens.h"
#include "datasets/camera/live_frame_source.h"

namespace pleinair {
namespace {

// How far beyond its border, in shares of its longer side, `of` would have to reach to cover the
// view of `camera`.
double Missing(const CameraIntrinsics& camera, const CameraIntrinsics& of) {
  constexpr int kSteps = 16;
  const Lens lens(camera);
  const Lens source(of);
  double most_px = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = (camera.width_px - 1) * static_cast<double>(i) / kSteps;
    const double y = (camera.height_px - 1) * static_cast<double>(i) / kSteps;
    for (const glm::dvec2& pixel : {glm::dvec2(x, 0.0),
                                    glm::dvec2(x, camera.height_px - 1),
                                    glm::dvec2(0.0, y),
                                    glm::dvec2(camera.width_px - 1, y)}) {
      const auto direction = lens.DirectionFromPixel(pixel);
      if (!direction) continue;  // The lens sees nothing there.
      const auto seen = source.ProjectToPixel(*direction);
      if (!seen) return std::numeric_limits<double>::infinity();
      most_px = std::max(
          {most_px, -seen->x, -seen->y, seen->x - (of.width_px - 1), seen->y - (of.height_px - 1)});
    }
  }
  return most_px / std::max(of.width_px, of.height_px);
}

}  // namespace

bool SeesAlike(const CameraIntrinsics& from, const CameraIntrinsics& to) {
  constexpr double kMostMissing = 0.03;
  return from == to || Missing(to, from) <= kMostMissing;
}

Rgb8Image SeenBy(const CameraIntrinsics& camera,
                 const Rgb8Image& picture,
                 const CameraIntrinsics& taken_by) {
  // Reduced first: then a pixel is the mean of those that it covers.
  const double shrink =
      std::min(1.0, static_cast<double>(camera.width_px) / static_cast<double>(picture.width));
  const cv::Mat stored(
      picture.height, picture.width, CV_8UC3, const_cast<glm::u8vec3*>(picture.pixels.data()));
  cv::Mat reduced;
  cv::resize(stored,
             reduced,
             cv::Size(std::max(1, static_cast<int>(std::lround(picture.width * shrink))),
                      std::max(1, static_cast<int>(std::lround(picture.height * shrink)))),
             0.0,
             0.0,
             cv::INTER_AREA);
  const CameraIntrinsics source = ScaledTo(taken_by, reduced.cols, reduced.rows);
  Rgb8Image seen(camera.width_px, camera.height_px);
  cv::Mat target(seen.height, seen.width, CV_8UC3, seen.pixels.data());
  if (source == camera) {
    reduced.copyTo(target);
    return seen;
  }
  const Lens lens(camera);
  const Lens source_lens(source);
  cv::Mat2f from(seen.height, seen.width, cv::Vec2f(-1.0F, -1.0F));
  for (int y = 0; y < seen.height; ++y) {
    for (int x = 0; x < seen.width; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      const auto pixel = direction ? source_lens.ProjectToPixel(*direction) : std::nullopt;
      if (!pixel) continue;
      from(y, x) = {static_cast<float>(pixel->x), static_cast<float>(pixel->y)};
    }
  }
  cv::remap(reduced, target, from, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return seen;
}

}  // namespace pleinair
