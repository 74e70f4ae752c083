#include "scene/internal/radiance_hdr.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "scene/internal/encoded_image.h"

namespace pleinair {
namespace {

using Rgbe = std::array<std::uint8_t, 4>;

// Scan lines within these bounds may be run-length coded, channel by channel.
constexpr int kMinRunWidth = 8;
constexpr int kMaxRunWidth = 0x7fff;

// Reads a picture's bytes front to back; every read is checked.
class HdrReader {
 public:
  HdrReader(const std::filesystem::path& file, std::span<const std::byte> bytes)
      : file_(file), bytes_(bytes) {}

  [[noreturn]] void Refuse(const std::string& why) const {
    throw std::runtime_error(file_.string() + ": " + why);
  }

  std::uint8_t Byte() {
    if (offset_ >= bytes_.size()) Refuse("the Radiance picture is truncated");
    return std::to_integer<std::uint8_t>(bytes_[offset_++]);
  }

  Rgbe Pixel() { return {Byte(), Byte(), Byte(), Byte()}; }

  std::string Line() {
    std::string line;
    for (char c = static_cast<char>(Byte()); c != '\n'; c = static_cast<char>(Byte())) {
      line.push_back(c);
      if (line.size() > 4096) Refuse("not a Radiance picture: a header line without end");
    }
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line;
  }

 private:
  const std::filesystem::path& file_;
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
};

// Returns the factor from stored to scene values.
double ReadHeader(HdrReader& reader) {
  if (!reader.Line().starts_with("#?")) reader.Refuse("not a Radiance picture: no #? in front");
  double scale = 1.0;
  for (std::string line = reader.Line(); !line.empty(); line = reader.Line()) {
    if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
      reader.Refuse("'" + line + "': expected FORMAT=32-bit_rle_rgbe");
    }
    constexpr std::string_view kExposure = "EXPOSURE=";
    if (line.starts_with(kExposure)) {
      std::string_view text = std::string_view(line).substr(kExposure.size());
      while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
      double exposure = 0.0;
      const auto result = std::from_chars(text.data(), text.data() + text.size(), exposure);
      if (result.ec != std::errc() || !(exposure > 0.0) || !std::isfinite(exposure)) {
        reader.Refuse("'" + line + "': expected a positive number");
      }
      scale /= exposure;
    }
  }
  if (!(scale > 0.0) || !std::isfinite(scale)) reader.Refuse("EXPOSURE: the product overflows");
  return scale;
}

struct Resolution {
  int width = 0;
  int height = 0;
  bool bottom_first = false;
  bool right_first = false;
};

Resolution ReadResolution(const std::filesystem::path& file,
                          std::size_t file_bytes,
                          HdrReader& reader) {
  const std::string line = reader.Line();
  std::array<std::string_view, 4> words;
  std::string_view rest = line;
  for (std::string_view& word : words) {
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(word.size());
  }
  std::array<std::int64_t, 2> sides{};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string_view text = words[2 * i + 1];
    const auto result = std::from_chars(text.data(), text.data() + text.size(), sides[i]);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size()) sides[i] = 0;
  }
  const bool upright = (words[0] == "-Y" || words[0] == "+Y") &&
                       (words[2] == "+X" || words[2] == "-X") && sides[0] > 0 && sides[1] > 0;
  if (!upright) reader.Refuse("resolution line '" + line + "': expected -Y HEIGHT +X WIDTH");
  RequireImageSize(file, sides[1], sides[0], file_bytes);
  return {
      static_cast<int>(sides[1]), static_cast<int>(sides[0]), words[0] == "+Y", words[2] == "-X"};
}

void ReadRuns(HdrReader& reader, std::vector<Rgbe>& row) {
  for (std::size_t channel = 0; channel < 4; ++channel) {
    for (std::size_t x = 0; x < row.size();) {
      const std::size_t code = reader.Byte();
      const bool run = code > 128;
      const std::size_t count = run ? code - 128 : code;
      if (count == 0 || count > row.size() - x) {
        reader.Refuse("the Radiance picture is damaged: a run leaves its scan line");
      }
      const std::uint8_t repeated = run ? reader.Byte() : std::uint8_t{0};
      for (std::size_t i = 0; i < count; ++i) {
        row[x++][channel] = run ? repeated : reader.Byte();
      }
    }
  }
}

// Old run-length form: a pixel (1, 1, 1, n) repeats the one before n times, shifted by eight bits
// for each such pixel in a row. Plain pixels are the case without any.
void ReadPlain(HdrReader& reader, Rgbe first, std::vector<Rgbe>& row) {
  unsigned shift = 0;
  Rgbe pixel = first;
  for (std::size_t x = 0; x < row.size();) {
    const bool repeats = pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1;
    if (repeats) {
      const std::size_t count = shift < 32 ? std::size_t{pixel[3]} << shift : row.size() + 1;
      if (x == 0 || count > row.size() - x) {
        reader.Refuse("the Radiance picture is damaged: a run leaves its scan line");
      }
      std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), count, row[x - 1]);
      x += count;
      shift += 8;
    } else {
      row[x++] = pixel;
      shift = 0;
    }
    if (x < row.size()) pixel = reader.Pixel();
  }
}

void ReadRow(HdrReader& reader, std::vector<Rgbe>& row) {
  const Rgbe first = reader.Pixel();
  const int width = static_cast<int>(row.size());
  const bool runs = width >= kMinRunWidth && width <= kMaxRunWidth && first[0] == 2 &&
                    first[1] == 2 && (first[2] << 8 | first[3]) == width;
  if (runs) {
    ReadRuns(reader, row);
  } else {
    ReadPlain(reader, first, row);
  }
}

// The exponent's byte is biased by 128, and the mantissas are 1/256 of a unit. 0 is black.
glm::vec3 Radiance(const Rgbe& pixel, double scale) {
  if (pixel[3] == 0) return glm::vec3(0.0f);
  const double unit = std::ldexp(scale, pixel[3] - (128 + 8));
  return glm::vec3(glm::dvec3(pixel[0], pixel[1], pixel[2]) * unit);
}

Rgbe Encode(const glm::vec3& radiance) {
  const float largest = std::max({radiance.x, radiance.y, radiance.z});
  int exponent = 0;
  std::frexp(largest, &exponent);
  // The largest mantissa may round up to 256: then the next exponent holds it.
  if (std::lround(std::ldexp(largest, 8 - exponent)) > 255) ++exponent;
  if (largest <= 0.0f || exponent < -127) return {0, 0, 0, 0};
  const auto mantissa = [&](float value) {
    return static_cast<std::uint8_t>(std::lround(std::ldexp(value, 8 - exponent)));
  };
  return {mantissa(radiance.x),
          mantissa(radiance.y),
          mantissa(radiance.z),
          static_cast<std::uint8_t>(exponent + 128)};
}

void Append(std::vector<std::byte>& bytes, std::size_t value) {
  bytes.push_back(static_cast<std::byte>(value));
}

// Runs of at least kMinRun equal bytes are packed; what lies between is copied.
void AppendRuns(std::vector<std::byte>& bytes, const std::vector<Rgbe>& row, std::size_t channel) {
  constexpr std::size_t kMinRun = 4;
  constexpr std::size_t kMaxRun = 127;
  constexpr std::size_t kMaxCopy = 128;
  const auto run_at = [&](std::size_t x) {
    std::size_t length = 1;
    while (length < kMaxRun && x + length < row.size() &&
           row[x + length][channel] == row[x][channel]) {
      ++length;
    }
    return length;
  };
  for (std::size_t x = 0; x < row.size();) {
    const std::size_t run = run_at(x);
    if (run >= kMinRun) {
      Append(bytes, 128 + run);
      Append(bytes, row[x][channel]);
      x += run;
      continue;
    }
    std::size_t end = x + 1;
    while (end < row.size() && end - x < kMaxCopy && run_at(end) < kMinRun) ++end;
    Append(bytes, end - x);
    for (; x < end; ++x) Append(bytes, row[x][channel]);
  }
}

}  // namespace

RgbImage DecodeRadianceHdr(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  HdrReader reader(file, bytes);
  const double scale = ReadHeader(reader);
  const Resolution resolution = ReadResolution(file, bytes.size(), reader);
  RgbImage image(resolution.width, resolution.height);
  std::vector<Rgbe> row(static_cast<std::size_t>(resolution.width));
  for (int line = 0; line < image.height; ++line) {
    ReadRow(reader, row);
    if (resolution.right_first) std::reverse(row.begin(), row.end());
    const int y = resolution.bottom_first ? image.height - 1 - line : line;
    for (int x = 0; x < image.width; ++x) {
      image.At(x, y) = Radiance(row[static_cast<std::size_t>(x)], scale);
    }
  }
  return image;
}

std::vector<std::byte> EncodeRadianceHdr(const RgbImage& image) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " +
                             std::to_string(image.height) + " +X " + std::to_string(image.width) +
                             "\n";
  std::vector<std::byte> bytes;
  for (const char c : header) Append(bytes, static_cast<unsigned char>(c));
  const bool runs = image.width >= kMinRunWidth && image.width <= kMaxRunWidth;
  std::vector<Rgbe> row(static_cast<std::size_t>(image.width));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::vec3& radiance = image.At(x, y);
      for (int channel = 0; channel < 3; ++channel) {
        if (!(radiance[channel] >= 0.0f) || !(radiance[channel] < 0x1p126f)) {
          throw std::invalid_argument("Radiance picture, pixel (" + std::to_string(x) + ", " +
                                      std::to_string(y) + "): value " +
                                      std::to_string(radiance[channel]) +
                                      " must be finite, not negative and below 2^126");
        }
      }
      row[static_cast<std::size_t>(x)] = Encode(radiance);
    }
    if (runs) {
      for (const int value : {2, 2, image.width >> 8, image.width & 255}) {
        Append(bytes, static_cast<std::size_t>(value));
      }
      for (std::size_t channel = 0; channel < 4; ++channel) AppendRuns(bytes, row, channel);
    } else {
      for (const Rgbe& pixel : row) {
        for (const std::uint8_t value : pixel) Append(bytes, value);
      }
    }
  }
  return bytes;
}

}  // namespace pleinair
