#include "session/picture_display.h"

#include <cstddef>
#include <cstdint>

#include "pipeline/display_codes.h"

namespace pleinair {

Rgb8Image PictureDisplay::Show(const RgbImage& radiance, std::optional<double> exposure) const {
  return CodesFromRadiance(radiance, response_, exposure.value_or(chosen_exposure_.value_or(1.0)));
}

Rgb8Image PictureDisplay::Show(const Frame& frame, const Composite& composite) {
  if (!frame.exposure && !chosen_exposure_) {
    // 8-bit frames of unknown exposure are in units of their own [0, 1].
    chosen_exposure_ = frame.codes ? 1.0 : ChosenExposure(frame.radiance);
  }
  Rgb8Image shown = Show(composite.radiance, frame.exposure);
  if (!frame.codes) return shown;
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    if (composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kNone)) {
      shown.pixels[i] = frame.codes->pixels[i];
    }
  }
  return shown;
}

}  // namespace pleinair
