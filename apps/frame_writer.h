// The files that `run` writes for each frame.
#pragma once

#include <filesystem>
#include <string>

#include "apps/run_command.h"
#include "render/compositor.h"
#include "scene/image.h"

namespace pleinair {

// Makes the folders that it writes to.
class FrameWriter {
 public:
  FrameWriter(const std::filesystem::path& out, WrittenPictures written);

  // As far as they are to be written: composite/NNNNNN.exr (scene-linear half),
  // composite/NNNNNN.png (`shown`, the composite as the camera would have shown it) and
  // mask/NNNNNN.png (PixelChange values).
  void Write(int frame, const Composite& composite, const Rgb8Image& shown) const;

  // Lat-long, 32-bit float: environment/NNNNNN.exr with the sun,
  // environment/NNNNNN_without_sun.exr.
  void WriteEnvironment(int frame, const RgbImage& with_sun, const RgbImage& without_sun) const;

  // Lat-long, 32-bit float, for lighting.jsonl's sky_image. Returns its path in the folder:
  // sky/NNNNNN.exr.
  std::string WriteSky(int frame, const RgbImage& sky) const;

 private:
  std::filesystem::path out_;
  WrittenPictures written_;
};

}  // namespace pleinair
