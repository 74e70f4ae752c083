// PNG and JPEG pictures. A PNG's check sums are made right: else no change would get past them.
#include <vector>

#include <zlib.h>

#include "scene/image_io.h"
#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

namespace {

std::uint32_t NumberAt(const std::uint8_t* at) {
  return std::uint32_t{at[0]} << 24U | at[1] << 16U | at[2] << 8U | at[3];
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  for (std::size_t at = 8; size > 1 && data[1] == 'P' && size >= at + 12;) {
    const std::size_t length = NumberAt(&bytes[at]);
    if (length > size - at - 12) break;
    const auto sum = crc32(0, &bytes[at + 4], static_cast<unsigned>(length + 4));
    for (int i = 0; i < 4; ++i) bytes[at + length + 8 + i] = sum >> (24 - 8 * i) & 0xffU;
    at += length + 12;
  }
  static const TemporaryFolder folder;
  const auto file = FuzzFile("picture", bytes.data(), size, folder);
  pleinair::ReadsOrRefuses([&] { pleinair::DescribeContent(file); });
  pleinair::ReadsOrRefuses([&] { pleinair::ReadMaskImage(file); });
  return pleinair::ReadsOrRefuses([&] { pleinair::ReadDisplayImage(file); });
}
