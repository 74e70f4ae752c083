// The stand-in as a stranger's program sees it: each test runs camera_client.cpp under it.
//
// Nothing here depends on how fast the machine is: times are those that the buffers state, and a
// slow client loses pictures, which the tests allow for.

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calib/response.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair {
namespace {

using Json = nlohmann::json;

const std::filesystem::path kCourtyard =
    std::filesystem::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";
constexpr int kPictures = 6;
constexpr int kWidth = 480;
constexpr int kHeight = 360;
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kMicrosecondNs = 1'000;  // What a buffer's timestamp is rounded to.

struct Result {
  int exit_code = -1;
  std::string output;

  std::vector<Json> Lines() const {
    std::vector<Json> lines;
    std::istringstream stream(output);
    for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  std::vector<Json> With(const std::string& key) const {
    std::vector<Json> found;
    for (const Json& line : Lines()) {
      if (line.contains(key)) found.push_back(line);
    }
    return found;
  }
  std::vector<Json> Frames() const { return With("sequence"); }
};

Result Shell(const std::string& command) {
  Result result;
  FILE* const pipe = popen(command.c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t bytes = fread(part.data(), 1, part.size(), pipe)) {
    result.output.append(part.data(), bytes);
  }
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

Result Program(const std::string& arguments) {
  std::string command = PLEINAIR_STAND_IN;
  command += " ";
  return Shell(command += arguments);
}

// `sequence` and options of the stand-in, then the client's mode, device and options.
Result StandIn(const std::string& options,
               const std::string& client,
               const std::filesystem::path& sequence = kCourtyard) {
  return Program("'" + sequence.string() + "' " + options + " -- " + PLEINAIR_CAMERA_CLIENT + " " +
                 client);
}

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
  const Result run =
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

TEST(CameraStandIn, ListsFormatsSizesRatesAndControls) {
  const Result list = StandIn("--rate 24", "list /dev/video90");
  ASSERT_EQ(list.exit_code, 0) << list.output;
  EXPECT_EQ(list.Lines()[0]["card"], "pleinair stand-in");
  EXPECT_EQ(list.Lines()[0]["bus"], "stand-in:90");
  std::string formats;
  for (const Json& line : list.With("format")) {
    formats += line["format"].get<std::string>() + " ";
    const Json& sizes = line["sizes"];
    ASSERT_GE(sizes.size(), 4u) << line;
    EXPECT_EQ(sizes[0], Json::array({480, 360, {24, 5, 10, 15, 20, 25, 30, 50, 60}}));
    for (const int width : {320, 640, 1280}) {
      EXPECT_TRUE(std::any_of(sizes.begin(), sizes.end(), [&](const Json& size) {
        return size[0] == width && size[1] == width * 3 / 4;
      })) << line;
    }
  }
  EXPECT_EQ(formats, "YUYV NV12 MJPG GREY RGB3 RGGB RG10 pRAA RG12 pRCC ");
  EXPECT_EQ(list.With("control").size(), 8u);
  for (const Json& control : list.With("value")) EXPECT_EQ(control["value"], control["normal"]);
  EXPECT_EQ(list.With("value").size(), 6u);  // All but the two headings.
}

TEST(CameraStandIn, AnswersCallsOutOfTurnAsDriversDo) {
  const Result rules = StandIn("--loop 0", "rules /dev/video90");
  ASSERT_EQ(rules.exit_code, 0) << rules.output;
  const Json expected{{"poll_idle", POLLERR},
                      {"stream_without_buffers", EINVAL},
                      {"unknown", ENOTTY},
                      {"format", true},
                      {"buffers", 0},
                      {"second_buffers", EBUSY},
                      {"second_format", false},
                      {"streamon", 0},
                      {"poll_empty", 0},
                      {"dequeue_empty", EAGAIN},
                      {"queue", 0},
                      {"queue_twice", EINVAL},
                      {"poll_filled", POLLIN},
                      {"free_streaming", EBUSY},
                      {"streamoff", 0},
                      {"free", 0},
                      {"second_then", 0},
                      {"first_then", 0}};
  EXPECT_EQ(rules.Lines()[0], expected);
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
  const Result run = StandIn("--rate 10 --pictures 1:4",
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
      const Result run = StandIn(options + " --pictures 0:0",
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

TEST(CameraStandIn, CountsAndTimesEveryTickAndEnds) {
  const Result run = StandIn("--rate 25 --loop 3", "stream /dev/video90 format=YUYV");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> frames = run.Frames();
  ASSERT_GE(frames.size(), 2u);
  const auto first_ns = frames[0]["time_ns"].get<std::int64_t>();
  for (const Json& frame : frames) {
    const auto time_ns = frame["time_ns"].get<std::int64_t>();
    const auto sequence = frame["sequence"].get<std::int64_t>();
    EXPECT_LE(std::abs(time_ns - first_ns - sequence * kSecondNs / 25), kMicrosecondNs);
    EXPECT_TRUE(frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC);
    EXPECT_EQ((frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_LAST) != 0, sequence == 17);
  }
  EXPECT_EQ(frames[0]["sequence"], 0);
  EXPECT_EQ(frames.back()["sequence"], 3 * kPictures - 1);
  EXPECT_EQ(run.Lines().back()["error"], EPIPE);
}

// Reading the two clocks takes some of it, on a busy machine.
constexpr std::int64_t kClockReadingNs = kSecondNs / 1000;

TEST(CameraStandIn, StartsAtTheRecordingsTime) {
  const Result run = StandIn("--rate 25 --loop 3 --pictures 2:4", "stream /dev/video90");
  const auto expected = ReadSequence(kCourtyard).frames[2].time.time_since_epoch().count();
  const std::vector<Json> frames = run.Frames();
  ASSERT_FALSE(frames.empty());
  const auto first_ns = frames[0]["time_ns"].get<std::int64_t>();
  for (const Json& frame : frames) {
    EXPECT_LE(std::abs(first_ns + frame["offset_ns"].get<std::int64_t>() - expected),
              kClockReadingNs);
  }
}

TEST(CameraStandIn, DropsPicturesThatFindNoBufferAndCountsThem) {
  const Result run = StandIn("--rate 30 --loop 6", "stream /dev/video90 hold_at=5");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> frames = run.Frames();
  // Half a second is 15 pictures; the client held one buffer, and three could be filled.
  EXPECT_LE(frames.size(), 36u - 11u);
  EXPECT_EQ(frames.back()["sequence"], 35);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto ticks = frames[i]["sequence"].get<int>() - frames[i - 1]["sequence"].get<int>();
    const auto time =
        frames[i]["time_ns"].get<std::int64_t>() - frames[i - 1]["time_ns"].get<std::int64_t>();
    EXPECT_LE(std::abs(time - ticks * kSecondNs / 30), kMicrosecondNs);
  }
}

TEST(CameraStandIn, ControlsReachTheFrameThatIsDue) {
  for (const int delay : {1, 4}) {
    const Result run = StandIn("--rate 20 --loop 0 --pictures 0:0 --control-delay " +
                                   std::to_string(delay) + " --fault unplug@1.5",
                               "stream /dev/video90 format=RG12 set_at=3 exposure=50");
    const std::vector<Json> writes = run.With("set");
    ASSERT_EQ(writes.size(), 1u) << run.output;
    EXPECT_EQ(writes[0]["set"], 0);
    EXPECT_EQ(writes[0]["value"], 50);
    const std::vector<Json> frames = run.Frames();
    const double before = frames[0]["mean"];
    const auto changed = std::find_if(frames.begin(), frames.end(), [&](const Json& frame) {
      return frame["mean"].get<double>() != before;
    });
    ASSERT_NE(changed, frames.end());
    // The last frame that had been captured when the control was written.
    const std::int64_t interval = kSecondNs / 20;
    const std::int64_t last = (*changed)["time_ns"].get<std::int64_t>() - delay * interval;
    const auto missing =
        (*changed)["sequence"].get<int>() - (*(changed - 1))["sequence"].get<int>() - 1;
    EXPECT_LE(last - missing * interval, writes[0]["after_ns"].get<std::int64_t>());
    EXPECT_GE(last + interval + kMicrosecondNs, writes[0]["before_ns"].get<std::int64_t>());
    for (auto frame = changed; frame != frames.end(); ++frame) {
      EXPECT_EQ((*frame)["mean"], (*changed)["mean"]);
    }
  }
}

TEST(CameraStandIn, ExposureScalesTheLight) {
  const TemporaryFolder folder;
  const Result run =
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

std::string Faulty(const std::string& faults) { return "--rate 20 --loop 6 --fault " + faults; }

TEST(CameraStandIn, UnplugsAndComesBack) {
  for (const bool renumbered : {false, true}) {
    const Result run = StandIn(Faulty(renumbered ? "unplug-renumber@0.5" : "unplug@0.5"),
                               "stream /dev/video90 recover=1");
    ASSERT_EQ(run.exit_code, 0) << run.output;
    const std::vector<Json> errors = run.With("error");
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0]["error"], ENODEV);
    EXPECT_TRUE(errors[0]["poll"].get<int>() & POLLERR);
    EXPECT_TRUE(errors[0]["poll"].get<int>() & POLLHUP);
    const std::vector<Json> starts = run.With("device");
    ASSERT_EQ(starts.size(), 2u);
    EXPECT_EQ(starts[1]["device"], renumbered ? "/dev/video91" : "/dev/video90");
    const std::vector<Json> frames = run.Frames();
    const auto again = std::find_if(
        frames.begin() + 1, frames.end(), [](const Json& frame) { return frame["sequence"] == 0; });
    ASSERT_NE(again, frames.end());
    EXPECT_GE(
        (*again)["time_ns"].get<std::int64_t>() - (*(again - 1))["time_ns"].get<std::int64_t>(),
        kSecondNs);
    EXPECT_LE((*(again - 1))["sequence"].get<int>(), 9);  // Stream time 0.45 s.
    // It goes on with the next picture: 10 were played before.
    EXPECT_EQ(frames.back()["sequence"], 6 * kPictures - 10 - 1);
  }
}

TEST(CameraStandIn, Stalls) {
  const Result run = StandIn(Faulty("stall@0.5"), "stream /dev/video90");
  const std::vector<Json> frames = run.Frames();
  const auto after =
      std::adjacent_find(frames.begin(), frames.end(), [](const Json& a, const Json& b) {
        return b["time_ns"].get<std::int64_t>() - a["time_ns"].get<std::int64_t>() >= 3 * kSecondNs;
      });
  ASSERT_NE(after, frames.end()) << run.output;
  EXPECT_LE((*after)["sequence"].get<int>(), 9);
  EXPECT_EQ(frames.back()["sequence"], 6 * kPictures - 1);  // No picture was lost by it.
  EXPECT_EQ(run.exit_code, 0);
}

TEST(CameraStandIn, StallsForever) {
  const Result run = Program(kCourtyard.string() + " " + Faulty("stall-forever@0.2 -- timeout 3 ") +
                             PLEINAIR_CAMERA_CLIENT + " stream /dev/video90");
  EXPECT_EQ(run.exit_code, 124);  // timeout's.
  ASSERT_FALSE(run.Frames().empty());
  EXPECT_LE(run.Frames().back()["sequence"].get<int>(), 3);
}

TEST(CameraStandIn, ChangesItsSizeAndBack) {
  const Result run =
      StandIn(Faulty("format-change@0.5,format-change@1"), "stream /dev/video90 recover=1");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> errors = run.With("error");
  ASSERT_EQ(errors.size(), 3u);
  const std::vector<Json> events = run.With("event");
  ASSERT_EQ(events.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(errors[i]["error"], EIO);
    EXPECT_EQ(errors[i]["poll"].get<int>() & (POLLERR | POLLPRI), POLLERR | POLLPRI);
    EXPECT_EQ(events[i]["event"], V4L2_EVENT_SOURCE_CHANGE);
  }
  const std::vector<Json> starts = run.With("width");
  ASSERT_EQ(starts.size(), 3u);
  EXPECT_NE(starts[1]["width"], kWidth);
  EXPECT_EQ(starts[1]["width"], run.With("new_width")[0]["new_width"]);
  EXPECT_EQ(starts[2]["width"], kWidth);
}

TEST(CameraStandIn, TruncatesABuffer) {
  const Result run = StandIn(Faulty("truncate@0.5"), "stream /dev/video90");
  int short_ones = 0;
  for (const Json& frame : run.Frames()) {
    const int bytes = frame["bytes"];
    EXPECT_TRUE(bytes == kWidth * kHeight * 3 || bytes == kWidth * kHeight * 3 / 2) << bytes;
    short_ones += bytes < kWidth * kHeight * 3 ? 1 : 0;
  }
  EXPECT_EQ(short_ones, 1);
}

int CountFlagged(const Result& run) {
  const std::vector<Json> frames = run.Frames();
  return static_cast<int>(std::count_if(frames.begin(), frames.end(), [](const Json& frame) {
    return (frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_ERROR) != 0;
  }));
}

TEST(CameraStandIn, CorruptsBuffers) {
  EXPECT_EQ(CountFlagged(StandIn(Faulty("corrupt@0.4,corrupt@0.8"), "stream /dev/video90")), 2);
  // Every other damaged JPEG is one that the driver has not noticed.
  const Result run = StandIn("--rate 20 --loop 30 --pictures 3:3 --fault corrupt@0.4,corrupt@0.8",
                             "stream /dev/video90 format=MJPG");
  EXPECT_EQ(CountFlagged(run), 1);
  const std::vector<Json> frames = run.Frames();
  EXPECT_EQ(std::count_if(frames.begin(),
                          frames.end(),
                          [&](const Json& frame) { return frame["mean"] != frames[0]["mean"]; }),
            1);
}

TEST(CameraStandIn, RepeatsAndTurnsBackTimestamps) {
  const auto steps = [](const Result& run, auto&& is_one) {
    const std::vector<Json> frames = run.Frames();
    int count = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const std::int64_t step =
          frames[i]["time_ns"].get<std::int64_t>() - frames[i - 1]["time_ns"].get<std::int64_t>();
      count += is_one(step) ? 1 : 0;
    }
    return count;
  };
  const Result repeat = StandIn(Faulty("time-repeat@0.5"), "stream /dev/video90");
  EXPECT_EQ(steps(repeat, [](std::int64_t step) { return step == 0; }), 1) << repeat.output;
  const Result back = StandIn(Faulty("time-back@0.5"), "stream /dev/video90");
  EXPECT_EQ(steps(back, [](std::int64_t step) { return step < 0; }), 1) << back.output;
}

TEST(CameraStandIn, StepsTheWallClock) {
  for (const int direction : {-1, 1}) {
    const Result run = StandIn(Faulty(direction < 0 ? "clock-back@0.5" : "clock-forward@0.5"),
                               "stream /dev/video90");
    const std::vector<Json> frames = run.Frames();
    ASSERT_GE(frames.size(), 2u);
    const std::int64_t step = frames.back()["offset_ns"].get<std::int64_t>() -
                              frames.front()["offset_ns"].get<std::int64_t>();
    EXPECT_LE(std::abs(step - direction * 3600 * kSecondNs), 2 * kClockReadingNs);
  }
}

TEST(CameraStandIn, LosesSequenceNumbers) {
  const Result run = StandIn(Faulty("drop@0.5"), "stream /dev/video90");
  const std::vector<Json> frames = run.Frames();
  const auto jump =
      std::adjacent_find(frames.begin(), frames.end(), [](const Json& a, const Json& b) {
        return b["sequence"].get<int>() - a["sequence"].get<int>() > 5;
      });
  ASSERT_NE(jump, frames.end());
  EXPECT_LE((*jump)["sequence"].get<int>(), 9);
  EXPECT_GE((*(jump + 1))["sequence"].get<int>(), 15);
}

TEST(CameraStandIn, RefusesAndClampsControls) {
  const std::string client = "stream /dev/video90 set_at=0 exposure=400";
  const Json refused = StandIn(Faulty("control-refused@0"), client).With("set")[0];
  EXPECT_EQ(refused["set"], EBUSY);
  EXPECT_EQ(refused["value"], 100);
  const Json clamped = StandIn(Faulty("control-clamped@0"), client).With("set")[0];
  EXPECT_EQ(clamped["set"], 0);
  EXPECT_EQ(clamped["value"], 110);
}

TEST(CameraStandIn, RepeatsItsRandomFaults) {
  const std::string options = "--rate 60 --loop 12 --fault random:7:6@0.8";
  const auto ends = [&] {
    const Result run = StandIn(options, "stream /dev/video90 recover=1");
    EXPECT_EQ(run.exit_code, 0) << run.output;
    std::string errors;
    for (const Json& line : run.With("error")) errors += line["error"].dump() + " ";
    return errors;
  };
  const std::string first = ends();
  EXPECT_NE(first, std::to_string(EPIPE) + " ");  // Something ended the stream in between.
  EXPECT_EQ(ends(), first);
}

TEST(CameraStandIn, WorksInChildrenOfTheCommand) {
  const Result run =
      Program(kCourtyard.string() +
              " --number 7 -- bash -c 'test -c /dev/video7 && test -r /dev/video7 && " +
              PLEINAIR_CAMERA_CLIENT + " list /dev/video7 >/dev/null && " + "date -u +%Y-%m-%d'");
  EXPECT_EQ(run.output, "2005-06-21\n");
  EXPECT_EQ(run.exit_code, 0);
}

TEST(CameraStandIn, OpenCvReadsIt) {
  const Result run = StandIn("--rate 20 --loop 4", "opencv /dev/video90");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.Lines().back()["opened"], true);
  EXPECT_GE(run.Lines().back()["count"].get<int>(), 2);
}

TEST(CameraStandIn, PassesExitCodesAndSignalsOn) {
  const std::string start = kCourtyard.string() + " -- ";
  EXPECT_EQ(Program(start + "sh -c 'exit 7'").exit_code, 7);
  EXPECT_EQ(Program(start + "sh -c 'kill -TERM $PPID; exec sleep 60'").exit_code, 128 + SIGTERM);
  EXPECT_EQ(Program(start + "/no/such/command 2>/dev/null").exit_code, 127);
}

TEST(CameraStandIn, RefusesWrongInputInOneLine) {
  const std::string yard = kCourtyard.string();
  EXPECT_EQ(Program("/no/such/folder -- true 2>&1").exit_code, 2);
  for (const char* options : {"",
                              " --rate 0 -- true",
                              " --rate nan -- true",
                              " --pictures 2:9 -- true",
                              " --pictures 3:1 -- true",
                              " --pictures x -- true",
                              " --size 640 -- true",
                              " --size 99999x99999 -- true",
                              " --format RGB -- true",
                              " --number 256 -- true",
                              " --fault unplug -- true",
                              " --fault melt@1 -- true",
                              " --fault unplug@-1 -- true",
                              " --fault random:1@5 -- true"}) {
    const Result run = Program(yard + options + " 2>&1");
    EXPECT_EQ(run.exit_code, 2) << options;
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
    EXPECT_EQ(run.output.find("pleinair-camera-stand-in: "), 0u) << run.output;
  }
}

}  // namespace
}  // namespace pleinair
