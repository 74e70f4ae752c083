#include "pipeline/camera_matching.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>

#include <tbb/parallel_for.h>

#include "calib/frame_noise.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// A number in (0, 1].
double Uniform(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 1.0) * 0x1p-53; }

// A normal deviate of mean 0 and variance 1 (Box and Muller).
double Normal(std::uint64_t key) {
  const std::uint64_t first = HashBits(key);
  const double radius = std::sqrt(-2.0 * std::log(Uniform(first)));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform(HashBits(first ^ key)));
}

}  // namespace

void CameraMatchingOptions::Validate() const {
  if (camera_noise) camera_noise->Validate();
}

CameraMatching::CameraMatching(const CameraMatchingOptions& options) : options_(options) {
  options_.Validate();
}

double CameraMatching::BlurPx(const Frame& frame, const SurfaceView& view) {
  if (!options_.blur) return 0.0;
  if (frames_seen_ < kFrames && last_seen_ != frame.index) {
    edge_blur_.Add(frame.radiance, frame.clipped, view);
    ++frames_seen_;
    last_seen_ = frame.index;
  }
  return edge_blur_.Blur().sigma_px;
}

std::optional<double> CameraMatching::KnownBlurPx() const {
  if (!options_.blur) return 0.0;
  if (frames_seen_ < kFrames) return std::nullopt;
  return edge_blur_.Blur().sigma_px;
}

void CameraMatching::AddNoise(const Frame& frame,
                              const ResponseCurve& response,
                              Composite& composite) const {
  if (!options_.noise || !frame.codes) return;
  std::function<double(int, double)> variance;
  if (options_.camera_noise) {
    variance = [&](int, double signal) {
      return options_.camera_noise->Variance(std::clamp(signal, 0.0, 1.0));
    };
  } else {
    const FrameNoise measured = MeasureFrameNoise(*frame.codes, response);
    variance = [measured](int c, double signal) { return measured.Variance(c, signal); };
  }
  const double exposure = frame.exposure.value_or(1.0);
  const std::uint64_t of_frame = HashBits(static_cast<std::uint64_t>(frame.index));
  tbb::parallel_for(std::size_t{0}, composite.change.pixels.size(), [&](std::size_t i) {
    const auto change = static_cast<PixelChange>(composite.change.pixels[i]);
    if (change == PixelChange::kNone) return;
    for (int c = 0; c < 3; ++c) {
      float& light = composite.radiance.pixels[i][c];
      const double signal = exposure * double{light};
      // The camera clips it, and its noise with it.
      if (!(signal < 1.0)) continue;
      double missing = variance(c, signal);
      const double before = exposure * double{frame.radiance.pixels[i][c]};
      if (change == PixelChange::kScaled && before > 0.0) {
        const double ratio = signal / before;
        missing -= ratio * ratio * variance(c, before);
      }
      if (!(missing > 0.0) || !std::isfinite(missing)) continue;
      const double noise =
          std::sqrt(missing) * Normal(of_frame ^ (3 * i + static_cast<std::size_t>(c)));
      light = static_cast<float>(std::max(signal + noise, 0.0) / exposure);
    }
  });
}

}  // namespace pleinair
