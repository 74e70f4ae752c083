#include "datasets/internal/sampling_mask.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "datasets/camera/live_frame_source.h"
#include "datasets/diffuse_mask.h"
#include "datasets/internal/sequence_folder.h"

namespace pleinair {
namespace {

constexpr std::uint8_t kMaySample = 255;

// Pixels of `from` that pixel `i` of `to` covers, in part or completely.
struct Covered {
  int first = 0;
  int last = 0;
};
Covered CoveredBy(int i, int to, int from) {
  const auto corner = [&](int at) { return std::int64_t{at} * from; };
  return {static_cast<int>(corner(i) / to), static_cast<int>((corner(i + 1) - 1) / to)};
}

}  // namespace

Gray8Image ScaledMask(const Gray8Image& mask, int width_px, int height_px) {
  Gray8Image scaled(width_px, height_px);
  for (int y = 0; y < height_px; ++y) {
    const Covered rows = CoveredBy(y, height_px, mask.height);
    for (int x = 0; x < width_px; ++x) {
      const Covered columns = CoveredBy(x, width_px, mask.width);
      bool may_sample = true;
      for (int row = rows.first; row <= rows.last; ++row) {
        for (int column = columns.first; column <= columns.last; ++column) {
          may_sample = may_sample && mask.At(column, row) == kMaySample;
        }
      }
      scaled.At(x, y) = may_sample ? kMaySample : 0;
    }
  }
  return scaled;
}

SamplingMask::SamplingMask(const Sequence& sequence) : sequence_(sequence) {
  auto mask = ReadDiffuseMask(sequence);
  if (!mask || mask->is_over_map) return;
  mask_ = std::move(mask->image);
  RequireCameraSize(
      *mask_, sequence.intrinsics, "camera", sequence.folder / *sequence.diffuse_mask);
}

void SamplingMask::ApplyTo(Frame& frame) const {
  if (!mask_) return;
  const int width = frame.camera.intrinsics.width_px;
  const int height = frame.camera.intrinsics.height_px;
  Camera masked = sequence_.CameraOfFrame(0);
  masked.intrinsics = ScaledTo(masked.intrinsics, width, height);
  if (!(frame.camera == masked)) return;
  if (scaled_.width != width || scaled_.height != height) {
    scaled_ = ScaledMask(*mask_, width, height);
  }
  for (std::size_t i = 0; i < frame.unusable.pixels.size(); ++i) {
    if (scaled_.pixels[i] != kMaySample) frame.unusable.pixels[i] = kUnusable;
  }
}

}  // namespace pleinair
