// A camera's bytes as pictures: codes against the matrices of ITU-R BT.601, 709 and 2020, raw ones
// against ramps that bilinear demosaicing reproduces.
#include "datasets/camera/camera_picture.h"

#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "tests/datasets/raw_picture.h"

namespace pleinair::camera_picture_test {
namespace {

using testing::HasSubstr;

std::byte Byte(int value) { return static_cast<std::byte>(value); }

struct NamedCoding {
  const char* name;
  YuvCoding coding;
  double kr;
  double kb;
};
constexpr NamedCoding kCodings[] = {
    {"BT.601", {YuvMatrix::kBt601, false}, 0.299, 0.114},
    {"BT.601, full", {YuvMatrix::kBt601, true}, 0.299, 0.114},
    {"BT.709", {YuvMatrix::kBt709, false}, 0.2126, 0.0722},
    {"BT.709, full", {YuvMatrix::kBt709, true}, 0.2126, 0.0722},
    {"BT.2020", {YuvMatrix::kBt2020, false}, 0.2627, 0.0593},
    {"BT.2020, full", {YuvMatrix::kBt2020, true}, 0.2627, 0.0593},
};

// The definition, Y = kr R + kg G + kb B, Cb = (B - Y) / (2 - 2 kb), Cr = (R - Y) / (2 - 2 kr),
// inverted as a matrix.
glm::dvec3 ExactRgb(const NamedCoding& named, int y, int u, int v) {
  const glm::dvec3 luma(named.kr, 1.0 - named.kr - named.kb, named.kb);
  const glm::dvec3 cb = (glm::dvec3(0.0, 0.0, 1.0) - luma) / (2.0 - 2.0 * named.kb);
  const glm::dvec3 cr = (glm::dvec3(1.0, 0.0, 0.0) - luma) / (2.0 - 2.0 * named.kr);
  const glm::dmat3 rgb_from_yuv = glm::inverse(glm::transpose(glm::dmat3(luma, cb, cr)));
  const bool full = named.coding.is_full_range;
  const glm::dvec3 yuv((y - (full ? 0 : 16)) / (full ? 255.0 : 219.0),
                       (u - 128) / (full ? 255.0 : 224.0),
                       (v - 128) / (full ? 255.0 : 224.0));
  return glm::clamp(255.0 * (rgb_from_yuv * yuv), 0.0, 255.0);
}

// Half a code, and three factors that are rounded to 2^-17 of up to 255 + 128 + 128 codes.
constexpr double kCodeTolerance = 0.5 + 511.0 / 131072.0;

constexpr int kSteps = 18;  // Of 15 codes: 0 to 255.
constexpr int CodeOf(int step) { return 15 * step; }

// Of all u and v, row by row, and in a row all y.
struct YuvGrid {
  static constexpr int kRows = kSteps * kSteps;
  static int U(int row) { return CodeOf(row / kSteps); }
  static int V(int row) { return CodeOf(row % kSteps); }
};

struct ChromaRow {
  int y;  // Of the picture.
  int u;
  int v;
};

double WorstOfRow(const Rgb8Image& picture,
                  const ChromaRow& row,
                  const NamedCoding& named,
                  auto&& luma_of) {
  double worst = 0.0;
  for (int x = 0; x < picture.width; ++x) {
    const glm::dvec3 exact = ExactRgb(named, luma_of(x), row.u, row.v);
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(picture.At(x, row.y)[c] - exact[c]));
    }
  }
  return worst;
}

TEST(CameraPicture, YuyvIsTheExactMatrixToHalfACode) {
  // A pair of pixels has two different brightnesses.
  const auto luma_of = [](int x) { return x % 2 == 0 ? CodeOf(x / 2) : 255 - CodeOf(x / 2); };
  for (const NamedCoding& named : kCodings) {
    constexpr int kStride = 4 * kSteps + 6;
    std::vector<std::byte> bytes(kStride * YuvGrid::kRows, Byte(0x5a));
    for (int y = 0; y < YuvGrid::kRows; ++y) {
      for (int pair = 0; pair < kSteps; ++pair) {
        std::byte* at = bytes.data() + kStride * y + 4 * pair;
        at[0] = Byte(luma_of(2 * pair));
        at[1] = Byte(YuvGrid::U(y));
        at[2] = Byte(luma_of(2 * pair + 1));
        at[3] = Byte(YuvGrid::V(y));
      }
    }
    const auto picture = DecodeCodes(
        bytes, {{PixelCoding::kYuyv}, 2 * kSteps, YuvGrid::kRows, kStride, named.coding});
    ASSERT_TRUE(picture) << picture.error();
    double worst = 0.0;
    for (int y = 0; y < YuvGrid::kRows; ++y) {
      worst =
          std::max(worst, WorstOfRow(*picture, {y, YuvGrid::U(y), YuvGrid::V(y)}, named, luma_of));
    }
    EXPECT_LE(worst, kCodeTolerance) << named.name;
    EXPECT_GT(worst, 0.4) << "the grid reaches values between codes";
  }
}

// Rows come in pairs; the last one of an odd height stands alone.
TEST(CameraPicture, Nv12IsTheExactMatrixToHalfACode) {
  const auto luma_of = [](int x) { return CodeOf(x); };
  for (const NamedCoding& named : kCodings) {
    constexpr int kHeight = 2 * YuvGrid::kRows - 1;
    constexpr int kStride = kSteps + 5;
    std::vector<std::byte> bytes(kStride * (kHeight + YuvGrid::kRows), Byte(0x5a));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kSteps; ++x) bytes[kStride * y + x] = Byte(luma_of(x));
    }
    for (int row = 0; row < YuvGrid::kRows; ++row) {
      for (int x = 0; x < kSteps; x += 2) {
        std::byte* at = bytes.data() + kStride * (kHeight + row) + x;
        at[0] = Byte(YuvGrid::U(row));
        at[1] = Byte(YuvGrid::V(row));
      }
    }
    const auto picture =
        DecodeCodes(bytes, {{PixelCoding::kNv12}, kSteps, kHeight, kStride, named.coding});
    ASSERT_TRUE(picture) << picture.error();
    double worst = 0.0;
    for (int y = 0; y < kHeight; ++y) {
      worst = std::max(
          worst, WorstOfRow(*picture, {y, YuvGrid::U(y / 2), YuvGrid::V(y / 2)}, named, luma_of));
    }
    EXPECT_LE(worst, kCodeTolerance) << named.name;
    EXPECT_GT(worst, 0.4);
  }
}

struct ColourBar {
  glm::ivec3 rgb;
  glm::ivec3 yuv_601;
  glm::ivec3 yuv_709;
};
// The 8-bit codes of 100 % colour bars, in the limited range.
const ColourBar kColourBars[] = {
    {{255, 255, 255}, {235, 128, 128}, {235, 128, 128}},
    {{255, 255, 0}, {210, 16, 146}, {219, 16, 138}},
    {{0, 255, 255}, {170, 166, 16}, {188, 154, 16}},
    {{0, 255, 0}, {145, 54, 34}, {173, 42, 26}},
    {{255, 0, 255}, {106, 202, 222}, {78, 214, 230}},
    {{255, 0, 0}, {81, 90, 240}, {63, 102, 240}},
    {{0, 0, 255}, {41, 240, 110}, {32, 240, 118}},
    {{0, 0, 0}, {16, 128, 128}, {16, 128, 128}},
};

// The codes are rounded: half a code of Y is 0.58 of B, half a code of U up to 1.06, and B is
// rounded again.
TEST(CameraPicture, ColourBarsHaveTheirColours) {
  constexpr double kRounding = 0.5 * 255.0 / 219.0 + 0.5 * 1.8556 * 255.0 / 224.0 + 0.5;
  for (const YuvMatrix matrix : {YuvMatrix::kBt601, YuvMatrix::kBt709}) {
    for (const ColourBar& bar : kColourBars) {
      const glm::ivec3 yuv = matrix == YuvMatrix::kBt601 ? bar.yuv_601 : bar.yuv_709;
      const std::array bytes{Byte(yuv.x), Byte(yuv.y), Byte(yuv.x), Byte(yuv.z)};
      const auto picture = DecodeCodes(bytes, {{PixelCoding::kYuyv}, 2, 1, 4, {matrix, false}});
      ASSERT_TRUE(picture) << picture.error();
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(picture->At(0, 0)[c], bar.rgb[c], kRounding);
        EXPECT_EQ(picture->At(0, 0)[c], picture->At(1, 0)[c]);
      }
    }
  }
}

// Bytes that stand for a pixel each, or a channel each, whatever lies between the rows.
TEST(CameraPicture, GreyAndRgbAreTheirBytes) {
  constexpr int kWidth = 7;
  constexpr int kHeight = 5;
  std::mt19937 random(1);
  for (const int padding : {0, 9}) {
    for (const PixelCoding coding : {PixelCoding::kGrey, PixelCoding::kRgb}) {
      const int channels = coding == PixelCoding::kRgb ? 3 : 1;
      const int stride = channels * kWidth + padding;
      // The last row has no padding.
      std::vector<std::byte> bytes(static_cast<std::size_t>(stride * kHeight - padding));
      for (std::byte& byte : bytes) byte = Byte(static_cast<int>(random() % 256));
      const auto picture = DecodeCodes(bytes, {{coding}, kWidth, kHeight, stride, {}});
      ASSERT_TRUE(picture) << picture.error();
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          for (int c = 0; c < 3; ++c) {
            const int at = stride * y + channels * x + (channels == 3 ? c : 0);
            EXPECT_EQ(Byte(picture->At(x, y)[c]), bytes[static_cast<std::size_t>(at)]);
          }
        }
      }
    }
  }
}

class Jpeg {
 public:
  explicit Jpeg(const Rgb8Image& picture) {
    const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
    unsigned char* data = nullptr;
    unsigned long size = 0;
    const int status = tjCompress2(encoder.get(),
                                   reinterpret_cast<const unsigned char*>(picture.pixels.data()),
                                   picture.width,
                                   0,
                                   picture.height,
                                   TJPF_RGB,
                                   &data,
                                   &size,
                                   TJSAMP_444,
                                   100,
                                   0);
    if (status != 0) throw std::runtime_error(tjGetErrorStr2(encoder.get()));
    const auto* first = reinterpret_cast<const std::byte*>(data);
    bytes.assign(first, first + size);
    tjFree(data);
  }
  std::vector<std::byte> bytes;
};

constexpr int kJpegWidth = 48;
constexpr int kJpegHeight = 40;

Rgb8Image ColouredPicture() {
  Rgb8Image picture(kJpegWidth, kJpegHeight);
  for (int y = 0; y < kJpegHeight; ++y) {
    for (int x = 0; x < kJpegWidth; ++x) {
      picture.At(x, y) = {20 + 4 * x, 40 + 5 * y, 230 - 2 * x - 2 * y};
    }
  }
  return picture;
}

const PictureLayout kJpegLayout{{PixelCoding::kMjpeg}, kJpegWidth, kJpegHeight, 0, {}};

// At quality 100 coefficients are whole numbers: each of Y, U and V is off by 1/sqrt(12) = 0.29 of
// a code, and by as much from its own rounding. B = Y + 1.772 U is then off by
// 0.41 sqrt(1 + 1.772^2) = 0.83, and with its rounding by 0.88.
TEST(CameraPicture, MjpegRoundTripKeepsThePicture) {
  const Rgb8Image original = ColouredPicture();
  const auto picture = DecodeCodes(Jpeg(original).bytes, kJpegLayout);
  ASSERT_TRUE(picture) << picture.error();
  glm::dvec3 squares(0.0);
  for (std::size_t i = 0; i < original.pixels.size(); ++i) {
    const glm::dvec3 error = glm::dvec3(picture->pixels[i]) - glm::dvec3(original.pixels[i]);
    squares += error * error;
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_LE(std::sqrt(squares[c] / static_cast<double>(original.pixels.size())), 0.9);
  }
}

TEST(CameraPicture, ATruncatedMjpegIsAnError) {
  const std::vector<std::byte> bytes = Jpeg(ColouredPicture()).bytes;
  for (std::size_t size = 0; size < bytes.size(); size += size + 40 < bytes.size() ? 31 : 1) {
    const auto picture = DecodeCodes(std::span(bytes).first(size), kJpegLayout);
    ASSERT_FALSE(picture) << size << " of " << bytes.size();
    EXPECT_THAT(picture.error(), HasSubstr("JPEG"));
    EXPECT_EQ(picture.error().find('\n'), std::string::npos);
  }
}

TEST(CameraPicture, ADamagedMjpegIsAnError) {
  const std::vector<std::byte> bytes = Jpeg(ColouredPicture()).bytes;
  // An end in the middle of the picture, and no beginning.
  std::vector<std::byte> ended = bytes;
  ended[bytes.size() / 2] = Byte(0xff);
  ended[bytes.size() / 2 + 1] = Byte(0xd9);
  std::vector<std::byte> headless = bytes;
  headless[0] = Byte(0);
  for (const auto& damaged : {ended, headless}) {
    const auto picture = DecodeCodes(damaged, kJpegLayout);
    ASSERT_FALSE(picture);
    EXPECT_THAT(picture.error(), HasSubstr("damaged JPEG"));
  }
}

// `jpeg` with `count` bytes more before its first marker 0xff `code`.
std::vector<std::byte> Padded(std::vector<std::byte> jpeg, int code, std::size_t count) {
  const std::array marker = {Byte(0xff), Byte(code)};
  const auto at = std::search(jpeg.begin(), jpeg.end(), marker.begin(), marker.end());
  if (at == jpeg.end()) throw std::runtime_error("no such marker");
  jpeg.insert(at, count, Byte(0x55));
  return jpeg;
}

// As Logitech's C270 and C910 leave them in almost every picture.
TEST(CameraPicture, AnMjpegWithPaddingBeforeAMarkerIsDecoded) {
  setenv("TJ_RESTART", "3b", 1);  // A restart marker after every three blocks.
  const std::vector<std::byte> bytes = Jpeg(ColouredPicture()).bytes;
  unsetenv("TJ_RESTART");
  const auto expected = DecodeCodes(bytes, kJpegLayout);
  ASSERT_TRUE(expected) << expected.error();
  for (const int code : {0xd0, 0xd4, 0xd9, 0xdb}) {
    for (const std::size_t count : {1, 2, 9, 16}) {
      const auto picture = DecodeCodes(Padded(bytes, code, count), kJpegLayout);
      ASSERT_TRUE(picture) << picture.error();
      EXPECT_EQ(picture->pixels, expected->pixels);
    }
    // What a loss on the bus leaves.
    const auto lost = DecodeCodes(Padded(bytes, code, 300), kJpegLayout);
    ASSERT_FALSE(lost) << code;
    EXPECT_THAT(lost.error(), HasSubstr("damaged JPEG"));
  }
  std::vector<std::byte> truncated = Padded(bytes, 0xd0, 2);
  for (const std::size_t cut : {2, 100, 400}) {
    const auto picture =
        DecodeCodes(std::span(truncated).first(truncated.size() - cut), kJpegLayout);
    ASSERT_FALSE(picture) << cut;
    EXPECT_THAT(picture.error(), HasSubstr("damaged JPEG"));
  }
}

TEST(CameraPicture, AnMjpegOfAnotherSizeIsAnError) {
  PictureLayout layout = kJpegLayout;
  layout.width_px = 64;
  const auto picture = DecodeCodes(Jpeg(ColouredPicture()).bytes, layout);
  ASSERT_FALSE(picture);
  EXPECT_THAT(picture.error(), HasSubstr("expected a JPEG of 64x40 pixels, found 48x40"));
}

std::vector<PixelFormat> RawFormats() {
  std::vector<PixelFormat> formats;
  for (const BayerOrder order : kAllOrders) {
    for (const int bits : {8, 10, 12}) {
      formats.push_back({PixelCoding::kBayer, bits, false, order});
      if (bits > 8) formats.push_back({PixelCoding::kBayer, bits, true, order});
    }
  }
  return formats;
}

// A ramp of its own for each colour: exact in the mean of two or four neighbours.
double RampOf(int colour, int x, int y) {
  constexpr double kFirst[] = {40.0, 70.0, 200.0};
  constexpr double kAcross[] = {3.0, 1.0, -2.0};
  constexpr double kDown[] = {1.0, 4.0, -3.0};
  return kFirst[colour] + kAcross[colour] * x + kDown[colour] * y;
}

TEST(CameraPicture, BilinearDemosaicingReproducesLinearRamps) {
  // Not a multiple of four: the last group of RAW10 is half full.
  constexpr int kWidth = 14;
  constexpr int kHeight = 10;
  for (const PixelFormat& format : RawFormats()) {
    PictureLayout layout{format, kWidth, kHeight, 0, {}};
    const int scale = 1 << (format.bits - 8);
    const auto code_of = [&](int x, int y) {
      return scale * static_cast<int>(RampOf(ColourAt(format.order, x, y), x, y));
    };
    const std::vector<std::byte> bytes = RawPicture(layout, code_of, 3);
    const RawDevelopment development{16.0 * scale, 250.0 * scale, {2.0, 1.0, 1.5}};
    const auto picture = Develop(bytes, layout, development);
    ASSERT_TRUE(picture) << picture.error();
    double worst = 0.0;
    for (int y = 1; y + 1 < kHeight; ++y) {
      for (int x = 1; x + 1 < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          const double expected =
              (RampOf(c, x, y) - 16.0) / (250.0 - 16.0) * development.white_balance_rgb[c];
          worst = std::max(worst, std::abs(picture->signal_rgb.At(x, y)[c] - expected));
        }
      }
    }
    EXPECT_LE(worst, 1e-6) << NameOf(format) << ": a float holds 2 to 1.2e-7";
    EXPECT_EQ(std::ranges::count(picture->clipped.pixels, 1), 0);
  }
}

TEST(CameraPicture, PackedAndPlainRawPicturesAreTheSame) {
  std::mt19937 random(2);
  for (const int bits : {10, 12}) {
    for (const int width : {4, 6, 8, 10, 22}) {
      constexpr int kHeight = 6;
      std::vector<int> codes(static_cast<std::size_t>(width * kHeight));
      for (int& code : codes) code = static_cast<int>(random() % (1u << bits));
      const auto code_of = [&](int x, int y) {
        return codes[static_cast<std::size_t>(y * width + x)];
      };
      PictureLayout plain{
          {PixelCoding::kBayer, bits, false, BayerOrder::kGrbg}, width, kHeight, 0, {}};
      PictureLayout packed = plain;
      packed.format.is_packed = true;
      const auto plain_bytes = RawPicture(plain, code_of, 2);
      const auto packed_bytes = RawPicture(packed, code_of);
      const auto a = Develop(plain_bytes, plain, UsualDevelopment(bits));
      const auto b = Develop(packed_bytes, packed, UsualDevelopment(bits));
      ASSERT_TRUE(a && b);
      EXPECT_EQ(a->signal_rgb.pixels, b->signal_rgb.pixels) << bits << " bits, " << width;
      EXPECT_EQ(a->clipped.pixels, b->clipped.pixels);
    }
  }
}

// A sensor's black is a 16th of the range: 64 of 1023 in 10 bits.
TEST(CameraPicture, BlackIsZeroWhiteIsTheBalanceAndNoiseBelowBlackStaysNegative) {
  const RawDevelopment usual = UsualDevelopment(10);
  EXPECT_EQ(usual.black_level, 64.0);
  EXPECT_EQ(usual.white_level, 1023.0);
  const glm::dvec3 balance(1.9, 1.0, 1.4);
  for (const auto& [code, signal] : {std::pair{64, 0.0}, {1023, 1.0}, {32, -32.0 / 959.0}}) {
    PictureLayout layout{{PixelCoding::kBayer, 10, false, BayerOrder::kRggb}, 4, 4, 0, {}};
    const auto bytes = RawPicture(layout, [&, value = code](int, int) { return value; });
    const auto picture = Develop(bytes, layout, {64.0, 1023.0, balance});
    ASSERT_TRUE(picture);
    for (const glm::vec3& pixel : picture->signal_rgb.pixels) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], signal * balance[c], 1e-6);
    }
  }
}

// Each pixel in turn is made white: what then changes was made of it, and is flagged.
TEST(CameraPicture, FlagsEveryPixelThatAClippedColourIsIn) {
  constexpr int kWidth = 8;
  constexpr int kHeight = 6;
  for (const BayerOrder order : kAllOrders) {
    PictureLayout layout{{PixelCoding::kBayer, 10, false, order}, kWidth, kHeight, 0, {}};
    const auto develop = [&](int white_x, int white_y) {
      const auto bytes = RawPicture(layout, [&](int x, int y) {
        return x == white_x && y == white_y ? 1023 : 100 + 3 * x + 7 * y;
      });
      return Develop(bytes, layout, UsualDevelopment(10)).value();
    };
    const DevelopedPicture dark = develop(-1, -1);
    for (int white = 0; white < kWidth * kHeight; ++white) {
      const int white_x = white % kWidth;
      const int white_y = white / kWidth;
      const DevelopedPicture bright = develop(white_x, white_y);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          EXPECT_EQ(dark.clipped.At(x, y), 0);
          if (bright.signal_rgb.At(x, y) != dark.signal_rgb.At(x, y)) {
            EXPECT_EQ(bright.clipped.At(x, y), 1)
                << x << "," << y << " of " << white_x << "," << white_y;
          }
          // Interpolation reaches one pixel, and two where a border repeats its neighbour.
          const int reach = std::max(std::abs(x - white_x), std::abs(y - white_y));
          EXPECT_LE(bright.clipped.At(x, y), reach <= 2 ? 1 : 0);
        }
      }
    }
  }
}

TEST(CameraPicture, RefusesTheOtherKindOfPicture) {
  const std::vector<std::byte> bytes(1000);
  const auto codes = DecodeCodes(bytes, {{PixelCoding::kBayer}, 8, 8, 8, {}});
  ASSERT_FALSE(codes);
  EXPECT_THAT(codes.error(), HasSubstr("expected codes, found raw SRGGB8"));
  const auto raw = Develop(bytes, {{PixelCoding::kGrey}, 8, 8, 8, {}}, UsualDevelopment(8));
  ASSERT_FALSE(raw);
  EXPECT_THAT(raw.error(), HasSubstr("expected a raw one, found GREY"));
}

TEST(CameraPicture, RefusesADevelopmentThatIsNone) {
  const double nan = std::nan("");
  for (const RawDevelopment& wrong : {RawDevelopment{-1.0, 255.0, {1, 1, 1}},
                                      RawDevelopment{255.0, 255.0, {1, 1, 1}},
                                      RawDevelopment{nan, 255.0, {1, 1, 1}},
                                      RawDevelopment{0.0, nan, {1, 1, 1}},
                                      RawDevelopment{0.0, INFINITY, {1, 1, 1}},
                                      RawDevelopment{0.0, 255.0, {0, 1, 1}},
                                      RawDevelopment{0.0, 255.0, {1, nan, 1}},
                                      RawDevelopment{0.0, 255.0, {1, 1, INFINITY}}}) {
    EXPECT_THROW(wrong.Validate(), std::invalid_argument);
  }
}

}  // namespace
}  // namespace pleinair::camera_picture_test
