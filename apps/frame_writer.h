// What `run` leaves behind for each frame.
#pragma once

#include <filesystem>
#include <optional>

#include "calib/response.h"
#include "datasets/frame_source.h"
#include "render/compositor.h"

namespace pleinair {

// Writes composite/NNNNNN.exr (scene-linear half), composite/NNNNNN.png (as the camera would have
// shown it; where the camera gave code values, unchanged pixels keep them) and mask/NNNNNN.png
// (PixelChange values).
class FrameWriter {
 public:
  // Makes the folders. `response` is the 8-bit camera's.
  FrameWriter(const std::filesystem::path& out, ResponseCurve response);

  // The frame as a display would show it; for frames without exposure the first such frame decides
  // on one for all.
  Rgb8Image Display(const Frame& frame, const RgbImage& radiance);

  // The composite as written to the PNG.
  Rgb8Image Write(const Frame& frame, const Composite& composite);

 private:
  std::filesystem::path out_;
  ResponseCurve response_;
  std::optional<double> chosen_exposure_;
};

}  // namespace pleinair
