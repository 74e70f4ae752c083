// Converts light to the camera's own code values, for pictures that people view.
#pragma once

#include <optional>

#include "calib/response.h"
#include "render/compositor.h"
#include "scene/frame.h"
#include "scene/image.h"

namespace pleinair {

// One thread at a time.
class PictureDisplay {
 public:
  // `response` is the 8-bit camera's.
  explicit PictureDisplay(ResponseCurve response) : response_(response) {}

  const ResponseCurve& Response() const { return response_; }

  // Returns the picture at `exposure`; where that is unknown, at the exposure chosen for the first
  // composite shown, or 1.
  Rgb8Image Show(const RgbImage& radiance, std::optional<double> exposure) const;

  // Brighter by `stops` (powers of two). At 0, where the camera delivered code values, unchanged
  // pixels keep them; where it delivered no colour, the composite has none.
  Rgb8Image Show(const Frame& frame, const Composite& composite, double stops = 0.0);

 private:
  double ExposureOf(std::optional<double> stated) const;

  ResponseCurve response_;
  std::optional<double> chosen_exposure_;
};

}  // namespace pleinair
