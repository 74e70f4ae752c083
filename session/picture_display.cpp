#include "session/picture_display.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/display_codes.h"

namespace pleinair {
namespace {

bool IsGrey(const Rgb8Image& picture) {
  return std::ranges::all_of(picture.pixels,
                             [](const auto& rgb) { return rgb.x == rgb.y && rgb.y == rgb.z; });
}

// As converters of whole pictures do it (Rec. ITU-R BT.601); grey stays as it is.
void MakeGrey(Rgb8Image& picture) {
  for (auto& rgb : picture.pixels) {
    const double luma = 0.299 * rgb.x + 0.587 * rgb.y + 0.114 * rgb.z;
    rgb = glm::u8vec3(static_cast<std::uint8_t>(std::lround(luma)));
  }
}

}  // namespace

Rgb8Image PictureDisplay::Show(const RgbImage& radiance, std::optional<double> exposure) const {
  return CodesFromRadiance(radiance, response_, ExposureOf(exposure));
}

Rgb8Image PictureDisplay::Show(const Frame& frame, const Composite& composite, double stops) {
  if (!frame.exposure && !chosen_exposure_) chosen_exposure_ = ChosenExposure(frame);
  const double exposure = ExposureOf(frame.exposure) * std::exp2(stops);
  if (!frame.codes) return CodesFromRadiance(composite.radiance, response_, exposure);
  Rgb8Image shown = *frame.codes;
  if (stops != 0.0) {
    shown = CodesFromRadiance(composite.radiance, response_, exposure);
  } else {
    for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
      if (composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kNone)) {
        shown.pixels[i] = CodeFromRadiance(composite.radiance.pixels[i], response_, exposure);
      }
    }
  }
  if (IsGrey(*frame.codes)) MakeGrey(shown);
  return shown;
}

double PictureDisplay::ExposureOf(std::optional<double> stated) const {
  return stated.value_or(chosen_exposure_.value_or(1.0));
}

}  // namespace pleinair
