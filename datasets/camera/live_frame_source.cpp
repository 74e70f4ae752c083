#include "datasets/camera/live_frame_source.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "datasets/internal/site_frames.h"

namespace pleinair {
namespace {

class LiveFrameSource final : public FrameSource {
 public:
  LiveFrameSource(const Sequence& site,
                  CameraCapture& capture,
                  EventLog& events,
                  const CameraNoise& noise,
                  CameraFrameTap tap)
      : site_(site, noise), capture_(capture), events_(events), tap_(std::move(tap)) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    std::optional<CameraFrame> captured = capture_.Next();
    if (!captured) return std::nullopt;
    if (tap_) tap_(*captured);
    const int index = next_++;
    try {
      return Make(index, *captured);
    } catch (const std::exception& error) {
      events_.Add({captured->time, EventKind::kFrameDamaged, error.what()});
      return tl::make_unexpected(FrameError{index, captured->time, error.what()});
    }
  }

  std::optional<int> Count() const override { return std::nullopt; }

 private:
  // Throws std::runtime_error for a picture that cannot be decoded.
  Frame Make(int index, const CameraFrame& captured) const {
    const CapturedBuffer& buffer = captured.buffer;
    if (buffer.is_damaged) throw std::runtime_error("camera picture: the driver reports damage");
    FrameEntry taken;
    taken.time = captured.time;
    SetExposure(buffer.exposure, taken);
    if (buffer.layout.format.coding == PixelCoding::kBayer) {
      return site_.Make(index,
                        taken,
                        Decoded(Develop(buffer.bytes,
                                        buffer.layout,
                                        buffer.development.value_or(
                                            UsualDevelopment(buffer.layout.format.bits)))));
    }
    return site_.Make(index, taken, Decoded(DecodeCodes(buffer.bytes, buffer.layout)));
  }

  template <typename Picture>
  static Picture Decoded(tl::expected<Picture, std::string> picture) {
    if (!picture) throw std::runtime_error(picture.error());
    return std::move(*picture);
  }

  SiteFrames site_;
  CameraCapture& capture_;
  EventLog& events_;
  CameraFrameTap tap_;
  int next_ = 0;
};

}  // namespace

CameraIntrinsics ScaledTo(const CameraIntrinsics& site, int width_px, int height_px) {
  if (site.width_px == width_px && site.height_px == height_px) return site;
  constexpr double kMostStretch = 0.005;
  const double sx = static_cast<double>(width_px) / site.width_px;
  const double sy = static_cast<double>(height_px) / site.height_px;
  if (!(std::abs(sx / sy - 1.0) <= kMostStretch)) {
    throw std::runtime_error(
        fmt::format("camera picture: expected the shape of the site's camera, {}x{}, found {}x{}",
                    site.width_px,
                    site.height_px,
                    width_px,
                    height_px));
  }
  CameraIntrinsics scaled = site;
  scaled.width_px = width_px;
  scaled.height_px = height_px;
  scaled.fx_px *= sx;
  scaled.fy_px *= sy;
  // Integer coordinates are centres of pixels; their corners are what scales.
  scaled.cx_px = (site.cx_px + 0.5) * sx - 0.5;
  scaled.cy_px = (site.cy_px + 0.5) * sy - 0.5;
  return scaled;
}

std::unique_ptr<FrameSource> MakeLiveFrameSource(const Sequence& site,
                                                 CameraCapture& capture,
                                                 EventLog& events,
                                                 const CameraNoise& noise,
                                                 CameraFrameTap tap) {
  return std::make_unique<LiveFrameSource>(site, capture, events, noise, std::move(tap));
}

}  // namespace pleinair
