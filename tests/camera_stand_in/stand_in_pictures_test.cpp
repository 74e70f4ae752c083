// The stand-in's pictures: in each format what was recorded, within the rounding of that format.
#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "calib/response.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "tests/camera_stand_in/stand_in_client.h"

namespace pleinair::stand_in_pictures_test {
namespace {

using Json = nlohmann::json;

std::vector<std::uint8_t> Bytes(const std::filesystem::path& file) {
  const std::string content = ContentOf(file);
  return {content.begin(), content.end()};
}

// Pictures of a recording: radiance x exposure, and its codes.
struct Recorded {
  RgbImage linear;
  Rgb8Image codes;
};

std::vector<Recorded> ReadCourtyard() {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  std::vector<Recorded> pictures;
  for (const FrameEntry& frame : ReadSequence(kCourtyard).frames) {
    Recorded picture{ReadRadianceImage(kCourtyard / *frame.image), Rgb8Image(kWidth, kHeight)};
    for (std::size_t i = 0; i < picture.linear.pixels.size(); ++i) {
      glm::vec3& light = picture.linear.pixels[i];
      light *= static_cast<float>(*frame.exposure);
      picture.codes.pixels[i] = srgb.CodeFromLinear(light);
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

// Every picture that arrived, from a run without loops, with what it should be.
template <typename Check>
void ForEachPicture(const std::string& format, Check&& check, const std::string& options = "") {
  const TemporaryFolder folder;
  const ClientRun run =
      StandIn(options + " --rate 10",
              "stream /dev/video90 format=" + format + " out=" + folder.Path().string());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Recorded> recorded = ReadCourtyard();
  const std::vector<Json> frames = run.Frames();
  ASSERT_FALSE(frames.empty());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    check(Bytes(folder / (std::to_string(i) + ".raw")),
          recorded.at(frames[i]["sequence"].get<std::size_t>()));
  }
}

TEST(CameraStandIn, GivesLinearFramesAsSrgbCodes) {
  ForEachPicture("RGB3", [](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
    const auto* const codes = reinterpret_cast<const std::uint8_t*>(recorded.codes.pixels.data());
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), codes, codes + kWidth * kHeight * 3));
  });
}

// A recording that has 8-bit pictures gives those, bit for bit, and not what follows from its
// light.
TEST(CameraStandIn, GivesRecordedCodesBitForBit) {
  const TemporaryFolder folder;
  std::filesystem::copy(kCourtyard, folder / "yard", std::filesystem::copy_options::recursive);
  Json sequence = Json::parse(ContentOf(kCourtyard / "sequence.json"));
  sequence["radiometry"]["frames_ldr"] = "srgb8";
  std::vector<Rgb8Image> written;
  for (std::size_t i = 0; i < kPictures; ++i) {
    Rgb8Image codes(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) codes.At(x, y) = {x, x * y + 40 * i, y};
    }
    const std::string name = "frames/" + std::to_string(i) + ".png";
    WritePng(folder / "yard" / name, codes);
    sequence["frames"][i]["image_ldr"] = name;
    written.push_back(std::move(codes));
  }
  std::ofstream(folder / "yard/sequence.json") << sequence;
  std::filesystem::create_directory(folder / "out");
  const ClientRun run = StandIn("--rate 10 --pictures 1:4",
                                "stream /dev/video90 out=" + (folder / "out").string(),
                                folder / "yard");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> frames = run.Frames();
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames.back()["sequence"], 3);  // The end is never lost.
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto bytes = Bytes(folder / ("out/" + std::to_string(i) + ".raw"));
    const Rgb8Image& picture = written.at(frames[i]["sequence"].get<std::size_t>() + 1);
    const auto* const codes = reinterpret_cast<const std::uint8_t*>(picture.pixels.data());
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), codes, codes + kWidth * kHeight * 3));
  }
}

double Luma(const glm::u8vec3& code, double red, double blue) {
  return red * code.x + (1.0 - red - blue) * code.y + blue * code.z;
}

// 0.5 for the rounding of a code, 0.01 for that of the matrix' fixed-point weights.
constexpr double kCodeRounding = 0.51;

TEST(CameraStandIn, GivesYuyvWithinItsRounding) {
  ForEachPicture("YUYV", [](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
    ASSERT_EQ(bytes.size(), kWidth * kHeight * 2u);
    double worst_y = 0.0;
    double worst_cb = 0.0;
    double worst_cr = 0.0;
    for (std::size_t i = 0; i < recorded.codes.pixels.size(); i += 2) {
      const glm::dvec3 a(recorded.codes.pixels[i]);
      const glm::dvec3 b(recorded.codes.pixels[i + 1]);
      const double first = Luma(recorded.codes.pixels[i], 0.299, 0.114);
      const double second = Luma(recorded.codes.pixels[i + 1], 0.299, 0.114);
      const double luma = (first + second) / 2.0;
      const double scale = 224.0 / 255.0;
      const auto worse = [](double& worst, std::uint8_t found, double expected) {
        worst = std::max(worst, std::abs(found - expected));
      };
      worse(worst_y, bytes[2 * i], 16.0 + 219.0 / 255.0 * first);
      worse(worst_y, bytes[2 * i + 2], 16.0 + 219.0 / 255.0 * second);
      worse(worst_cb, bytes[2 * i + 1], 128.0 + scale * ((a.z + b.z) / 2.0 - luma) / 1.772);
      worse(worst_cr, bytes[2 * i + 3], 128.0 + scale * ((a.x + b.x) / 2.0 - luma) / 1.402);
    }
    EXPECT_LE(worst_y, kCodeRounding);
    EXPECT_LE(worst_cb, kCodeRounding);
    EXPECT_LE(worst_cr, kCodeRounding);
  });
}

TEST(CameraStandIn, GivesNv12OfTheMatrixAndRangeAskedFor) {
  const std::string options = "--ycbcr 709 --range full";
  const auto check = [](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
    ASSERT_EQ(bytes.size(), kWidth * kHeight * 3u / 2u);
    double worst = 0.0;
    for (std::size_t i = 0; i < recorded.codes.pixels.size(); ++i) {
      worst = std::max(worst, std::abs(bytes[i] - Luma(recorded.codes.pixels[i], 0.2126, 0.0722)));
    }
    EXPECT_LE(worst, kCodeRounding);
    for (const int x : {0, 200, kWidth - 2}) {
      double red = 0.0;
      double luma = 0.0;
      for (int k = 0; k < 4; ++k) {
        const glm::u8vec3 code = recorded.codes.At(x + k % 2, 100 + k / 2);
        red += code.x / 4.0;
        luma += Luma(code, 0.2126, 0.0722) / 4.0;
      }
      const std::size_t chroma = kWidth * kHeight + 50 * kWidth + static_cast<std::size_t>(x);
      EXPECT_NEAR(bytes[chroma + 1], 128.0 + (red - luma) / 1.5748, kCodeRounding);
    }
  };
  ForEachPicture("NV12", check, options);
  const Json header = StandIn(options, "stream /dev/video90 format=NV12").Lines()[0];
  EXPECT_EQ(header["encoding"], V4L2_YCBCR_ENC_709);
  EXPECT_EQ(header["quantization"], V4L2_QUANTIZATION_FULL_RANGE);
}

// The light of the pixel's colour above a black level of 1/16 of the range.
double RawValue(const Recorded& recorded, int x, int y, int bits) {
  const float light = recorded.linear.At(x, y)[y % 2 + x % 2];
  const double black = std::ldexp(1.0, bits - 4);
  const double white = std::ldexp(1.0, bits) - 1.0;
  return black + std::clamp<double>(light, 0.0, 1.0) * (white - black);
}

// 0.5 for rounding; half floats hold light to 2^-12 of itself, half a step of 11 bits.
double RawTolerance(int bits) { return 0.51 + std::ldexp(1.0, bits - 12); }

TEST(CameraStandIn, GivesRawBayerAboveItsBlackLevel) {
  for (const auto& [format, bits] : {std::pair{"RGGB", 8}, {"RG10", 10}, {"RG12", 12}}) {
    SCOPED_TRACE(format);
    const int count = bits;
    ForEachPicture(format, [&](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
      const std::size_t step = count == 8 ? 1 : 2;
      ASSERT_EQ(bytes.size(), kWidth * kHeight * step);
      double worst = 0.0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const std::size_t i = step * (static_cast<std::size_t>(y) * kWidth + x);
          const int value = bytes[i] + (step == 2 ? 256 * bytes[i + 1] : 0);
          worst = std::max(worst, std::abs(value - RawValue(recorded, x, y, count)));
        }
      }
      EXPECT_LE(worst, RawTolerance(count));
    });
  }
}

TEST(CameraStandIn, PacksRawBayerAsMipiDoes) {
  ForEachPicture("pRAA", [](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
    ASSERT_EQ(bytes.size(), kWidth * kHeight * 5u / 4u);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const std::size_t group = static_cast<std::size_t>(i / 4) * 5;
      const int value = 4 * bytes[group + i % 4] + (bytes[group + 4] >> (i % 4 * 2) & 3);
      ASSERT_NEAR(value, RawValue(recorded, i % kWidth, i / kWidth, 10), RawTolerance(10)) << i;
    }
  });
  ForEachPicture("pRCC", [](const std::vector<std::uint8_t>& bytes, const Recorded& recorded) {
    ASSERT_EQ(bytes.size(), kWidth * kHeight * 3u / 2u);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const std::size_t group = static_cast<std::size_t>(i / 2) * 3;
      const int value = 16 * bytes[group + i % 2] + (bytes[group + 2] >> (i % 2 * 4) & 15);
      ASSERT_NEAR(value, RawValue(recorded, i % kWidth, i / kWidth, 12), RawTolerance(12)) << i;
    }
  });
}

TEST(CameraStandIn, ResamplesToOtherSizes) {
  const std::vector<Recorded> recorded = ReadCourtyard();
  double mean = 0.0;
  for (const glm::u8vec3& code : recorded[0].codes.pixels) mean += code.x + code.y + code.z;
  mean /= kWidth * kHeight * 3.0;
  for (const std::string& options : {std::string("--size 640x480"), std::string()}) {
    for (const int width : {320, 640}) {
      const ClientRun run = StandIn(options + " --pictures 0:0",
                                    "stream /dev/video90 width=" + std::to_string(width) +
                                        " height=" + std::to_string(width * 3 / 4));
      ASSERT_EQ(run.exit_code, 0) << run.output;
      const Json frame = run.Frames().at(0);
      EXPECT_EQ(frame["bytes"], width * width * 3 / 4 * 3);
      // A picture's mean stays, but for what interpolation does along its edges.
      EXPECT_NEAR(frame["mean"].get<double>(), mean, 0.5);
    }
  }
}

TEST(CameraStandIn, ExposureScalesTheLight) {
  const TemporaryFolder folder;
  const ClientRun run =
      StandIn("--rate 20 --loop 8 --pictures 0:1",
              "stream /dev/video90 format=RG12 set_at=1 exposure=50 out=" + folder.Path().string());
  ASSERT_EQ(run.exit_code, 0);
  const Recorded recorded = ReadCourtyard()[1];
  const std::size_t last = run.Frames().size() - 1;  // Its picture is the second of the two.
  const auto bytes = Bytes(folder / (std::to_string(last) + ".raw"));
  double worst = 0.0;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const int x = i % kWidth;
    const int y = i / kWidth;
    const double light = std::clamp(recorded.linear.At(x, y)[y % 2 + x % 2] * 0.5, 0.0, 1.0);
    const int value =
        bytes[2 * static_cast<std::size_t>(i)] + 256 * bytes[2 * static_cast<std::size_t>(i) + 1];
    worst = std::max(worst, std::abs(value - (256.0 + light * (4095.0 - 256.0))));
  }
  EXPECT_LE(worst, RawTolerance(12));
}

}  // namespace
}  // namespace pleinair::stand_in_pictures_test
