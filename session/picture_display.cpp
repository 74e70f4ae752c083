#include "session/picture_display.h"

#include <cstddef>
#include <cstdint>

#include "pipeline/display_codes.h"

namespace pleinair {

Rgb8Image PictureDisplay::Show(const RgbImage& radiance, std::optional<double> exposure) const {
  return CodesFromRadiance(radiance, response_, ExposureOf(exposure));
}

Rgb8Image PictureDisplay::Show(const Frame& frame, const Composite& composite) {
  if (!frame.exposure && !chosen_exposure_) {
    // 8-bit frames of unknown exposure are in units of their own [0, 1].
    chosen_exposure_ = frame.codes ? 1.0 : ChosenExposure(frame.radiance);
  }
  if (!frame.codes) return Show(composite.radiance, frame.exposure);
  const double exposure = ExposureOf(frame.exposure);
  Rgb8Image shown = *frame.codes;
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    if (composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kNone)) {
      shown.pixels[i] = CodeFromRadiance(composite.radiance.pixels[i], response_, exposure);
    }
  }
  return shown;
}

double PictureDisplay::ExposureOf(std::optional<double> stated) const {
  return stated.value_or(chosen_exposure_.value_or(1.0));
}

}  // namespace pleinair
