// A camera's bytes in any of its formats: 8 bytes say how they are laid out.
#include "datasets/camera/camera_picture.h"

#include <cstdlib>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 8) return 0;
  using pleinair::PixelFormat;
  static const auto formats = [] {
    std::vector<PixelFormat> all;
    for (const char* name :
         {"YUYV", "NV12", "MJPEG", "GREY", "RGB24", "SRGGB8", "SGRBG10", "SGBRG10P", "SBGGR12P"}) {
      all.push_back(pleinair::PixelFormatNamed(name).value());
    }
    return all;
  }();
  pleinair::PictureLayout layout;
  layout.format = formats[data[0] % formats.size()];
  layout.yuv = {static_cast<pleinair::YuvMatrix>(data[1] % 3), data[1] > 127};
  layout.width_px = static_cast<std::int8_t>(data[2]) + (data[3] % 2) * 640;
  layout.height_px = static_cast<std::int8_t>(data[4]) + (data[5] % 2) * 480;
  layout.stride_bytes = data[6] + 256 * static_cast<std::int8_t>(data[7]);
  // Of its own size: what is read past its end is found.
  const std::vector<std::uint8_t> copy(data + 8, data + size);
  const auto bytes = std::as_bytes(std::span(copy));
  const auto codes = pleinair::DecodeCodes(bytes, layout);
  const auto raw = pleinair::Develop(bytes, layout, pleinair::UsualDevelopment(layout.format.bits));
  if (codes && raw) std::abort();  // No format is both.
  return 0;
}
