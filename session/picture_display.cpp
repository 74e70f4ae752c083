#include "session/picture_display.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/display_codes.h"

namespace pleinair {
namespace {

// Whether a camera without colours took it. Black and white are no evidence: any camera's pixels
// are so in the dark, or where they clip.
bool IsGrey(const Rgb8Image& picture) {
  constexpr std::size_t kEvidence = 100;  // One pixel among so many.
  std::size_t greys = 0;
  for (const auto& rgb : picture.pixels) {
    if (rgb.x != rgb.y || rgb.y != rgb.z) return false;
    if (rgb.x > 0 && rgb.x < 255) ++greys;
  }
  return greys * kEvidence > picture.pixels.size();
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
