#include "apps/frame_writer.h"

#include <fmt/format.h>

#include "pipeline/display_codes.h"
#include "scene/image_io.h"

namespace pleinair {
FrameWriter::FrameWriter(const std::filesystem::path& out, ResponseCurve response)
    : out_(out), response_(response) {
  std::filesystem::create_directories(out_ / "composite");
  std::filesystem::create_directories(out_ / "mask");
}

Rgb8Image FrameWriter::Display(const RgbImage& radiance, std::optional<double> exposure) const {
  return CodesFromRadiance(radiance, response_, exposure.value_or(chosen_exposure_.value_or(1.0)));
}

void FrameWriter::WriteEnvironment(int frame,
                                   const RgbImage& with_sun,
                                   const RgbImage& without_sun) const {
  const std::filesystem::path folder = out_ / "environment";
  std::filesystem::create_directories(folder);
  const std::string number = fmt::format("{:06}", frame);
  WriteExr(folder / (number + ".exr"), with_sun, ExrPrecision::kFloat);
  WriteExr(folder / (number + "_without_sun.exr"), without_sun, ExrPrecision::kFloat);
}

std::string FrameWriter::WriteSky(int frame, const RgbImage& sky) const {
  std::filesystem::create_directories(out_ / "sky");
  std::string name = fmt::format("sky/{:06}.exr", frame);
  WriteExr(out_ / name, sky, ExrPrecision::kFloat);
  return name;
}

Rgb8Image FrameWriter::Write(const Frame& frame, const Composite& composite) {
  if (!frame.exposure && !chosen_exposure_) {
    // 8-bit frames of unknown exposure are in units of their own [0, 1].
    chosen_exposure_ = frame.codes ? 1.0 : ChosenExposure(frame.radiance);
  }
  Rgb8Image display = Display(composite.radiance, frame.exposure);
  if (frame.codes) {
    for (std::size_t i = 0; i < display.pixels.size(); ++i) {
      if (composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kNone)) {
        display.pixels[i] = frame.codes->pixels[i];
      }
    }
  }
  const std::string number = fmt::format("{:06}", frame.index);
  WriteExr(out_ / "composite" / (number + ".exr"), composite.radiance, ExrPrecision::kHalf);
  WritePng(out_ / "composite" / (number + ".png"), display);
  WritePng(out_ / "mask" / (number + ".png"), composite.change);
  return display;
}

}  // namespace pleinair
