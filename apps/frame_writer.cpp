#include "apps/frame_writer.h"

#include <fmt/format.h>

#include "scene/image_io.h"

namespace pleinair {

FrameWriter::FrameWriter(const std::filesystem::path& out, WrittenPictures written)
    : out_(out), written_(written) {}

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

void FrameWriter::Write(int frame, const Composite& composite, const Rgb8Image& shown) const {
  if (written_ == WrittenPictures::kNone) return;
  for (const char* folder : {"composite", "mask"}) {
    std::filesystem::create_directories(out_ / folder);
  }
  const std::string number = fmt::format("{:06}", frame);
  if (written_ == WrittenPictures::kAll) {
    WriteExr(out_ / "composite" / (number + ".exr"), composite.radiance, ExrPrecision::kHalf);
  }
  WritePng(out_ / "composite" / (number + ".png"), shown);
  WritePng(out_ / "mask" / (number + ".png"), composite.change);
}

}  // namespace pleinair
