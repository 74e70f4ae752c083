#include "session/picture_display.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/display_codes.h"

namespace pleinair {

Rgb8Image PictureDisplay::Show(const RgbImage& radiance, std::optional<double> exposure) const {
  return CodesFromRadiance(radiance, response_, ExposureOf(exposure));
}

Rgb8Image PictureDisplay::Show(const Frame& frame, const Composite& composite, double stops) {
  if (!frame.exposure && !chosen_exposure_) chosen_exposure_ = ChosenExposure(frame);
  const double exposure = ExposureOf(frame.exposure) * std::exp2(stops);
  if (!frame.codes || stops != 0.0) {
    return CodesFromRadiance(composite.radiance, response_, exposure);
  }
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
