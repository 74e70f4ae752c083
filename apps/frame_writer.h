// What `run` leaves behind for each frame.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

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

  // Light as the camera would have shown it at `exposure`; where that is unknown, at one that was
  // chosen for the first frame written.
  Rgb8Image Display(const RgbImage& radiance, std::optional<double> exposure) const;

  // Lat-long, 32-bit float: environment/NNNNNN.exr with the sun,
  // environment/NNNNNN_without_sun.exr.
  void WriteEnvironment(int frame, const RgbImage& with_sun, const RgbImage& without_sun) const;

  // Lat-long, 32-bit float, for lighting.jsonl's sky_image. Returns its path in the folder:
  // sky/NNNNNN.exr.
  std::string WriteSky(int frame, const RgbImage& sky) const;

  // The composite as written to the PNG.
  Rgb8Image Write(const Frame& frame, const Composite& composite);

 private:
  std::filesystem::path out_;
  ResponseCurve response_;
  std::optional<double> chosen_exposure_;
};

}  // namespace pleinair
