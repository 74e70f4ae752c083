#include "datasets/camera/live_frame_source.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "calib/response.h"
#include "datasets/internal/sampling_mask.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/picture_frame.h"

namespace pleinair {
namespace {

class LiveFrameSource final : public FrameSource {
 public:
  LiveFrameSource(const Sequence& site,
                  CameraCapture& capture,
                  EventLog& events,
                  const CameraNoise& noise,
                  CameraFrameTap tap)
      : site_(site),
        capture_(capture),
        events_(events),
        response_(site.response_ldr == "srgb8"
                      ? ResponseCurve::Srgb()
                      : ResponseCurve::FromFile(FileInside(site.folder, site.response_ldr))),
        noise_(std::make_shared<SignalNoise>(response_, noise)),
        mask_(site_),
        tap_(std::move(tap)) {}

  std::optional<tl::expected<Frame, FrameError>> Next() override {
    std::optional<CameraFrame> captured = capture_.Next();
    if (!captured) return std::nullopt;
    if (tap_) tap_(*captured);
    Frame frame;
    frame.index = next_++;
    frame.time = captured->time;
    try {
      Fill(captured->buffer, frame);
    } catch (const std::exception& error) {
      events_.Add({captured->time, EventKind::kFrameDamaged, error.what()});
      return tl::make_unexpected(FrameError{frame.index, frame.time, error.what()});
    }
    return frame;
  }

  std::optional<int> Count() const override { return std::nullopt; }

 private:
  // Throws std::runtime_error for a picture that cannot be decoded.
  void Fill(const CapturedBuffer& buffer, Frame& frame) {
    if (buffer.is_damaged) throw std::runtime_error("camera picture: damaged, says the driver");
    frame.camera = site_.CameraOfFrame(0);
    frame.camera.intrinsics =
        ScaledTo(frame.camera.intrinsics, buffer.layout.width_px, buffer.layout.height_px);
    frame.sun_direction_enu = site_.StatedSunDirectionEnu(0);
    frame.weather = site_.WeatherOfFrame(0);
    FrameEntry settings;
    settings.exposure_s = buffer.exposure.exposure_s;
    settings.iso = IsoOf(buffer.exposure);
    settings.f_number = 1.0;
    frame.exposure = settings.EffectiveExposure();
    if (buffer.layout.format.coding == PixelCoding::kBayer) {
      FillRaw(buffer, frame);
    } else {
      auto codes = DecodeCodes(buffer.bytes, buffer.layout);
      if (!codes) throw std::runtime_error(codes.error());
      SetCodes(std::move(*codes), response_, noise_, frame);
    }
    frame.units = frame.exposure ? LightUnits::kRelative : LightUnits::kRelativePerFrame;
    mask_.ApplyTo(frame);
  }

  static void FillRaw(const CapturedBuffer& buffer, Frame& frame) {
    auto developed =
        Develop(buffer.bytes,
                buffer.layout,
                buffer.development.value_or(UsualDevelopment(buffer.layout.format.bits)));
    if (!developed) throw std::runtime_error(developed.error());
    const auto scale = static_cast<float>(1.0 / frame.exposure.value_or(1.0));
    for (glm::vec3& pixel : developed->signal_rgb.pixels) pixel *= scale;
    SetRadiance(std::move(developed->signal_rgb), frame);
    frame.clipped = std::move(developed->clipped);
    for (std::size_t i = 0; i < frame.clipped.pixels.size(); ++i) {
      if (frame.clipped.pixels[i] == 0) continue;
      frame.unusable.pixels[i] |= kClipped[0] | kClipped[1] | kClipped[2];
    }
  }

  const Sequence site_;
  CameraCapture& capture_;
  EventLog& events_;
  ResponseCurve response_;
  std::shared_ptr<const SignalNoise> noise_;
  SamplingMask mask_;
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
