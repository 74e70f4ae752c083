// Times what a recorder does with every picture, and its encoders alone: 33.3 ms are one core at 30
// pictures a second.
#include <cmath>
#include <cstdint>
#include <filesystem>

#include <benchmark/benchmark.h>

#include "datasets/recording/recording.h"
#include "datasets/video/video_writer.h"
#include "scene/image_io.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
const fs::path kSite = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

// A new folder for each bench, removed with it.
class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / "pleinair_recorder_bench") { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  const fs::path path;
};

// Smooth, with the noise of a sensor: two or three codes.
CameraFrame Picture(PixelCoding coding, int bytes_a_pixel) {
  CameraFrame frame;
  CapturedBuffer& buffer = frame.buffer;
  buffer.layout = {{coding}, kWidth, kHeight, bytes_a_pixel * kWidth, {}};
  buffer.bytes.resize(static_cast<std::size_t>(bytes_a_pixel * kWidth * kHeight));
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < buffer.bytes.size(); ++i) {
    state = state * 1664525u + 1013904223u;
    const double smooth = 120.0 + 60.0 * std::sin(static_cast<double>(i) / 5000.0);
    buffer.bytes[i] = static_cast<std::byte>(static_cast<int>(smooth) + (state >> 30));
  }
  buffer.exposure = {0.004, 1.0};
  return frame;
}

void Record(benchmark::State& state, PixelCoding coding, int bytes_a_pixel, PictureStore store) {
  const Folder folder;
  CameraFrame picture = Picture(coding, bytes_a_pixel);
  RecordingOptions options;
  options.folder = folder.path;
  options.store = store;
  Recording recording(ReadSite(kSite, UtcTime{}), picture.buffer.layout, options);
  std::uint64_t bytes = 0;
  for (auto _ : state) {
    picture.time += std::chrono::milliseconds(33);
    picture.buffer.monotonic_time += std::chrono::milliseconds(33);
    bytes += recording.Add(picture).value();
  }
  state.counters["bytes"] =
      benchmark::Counter(static_cast<double>(bytes), benchmark::Counter::kAvgIterations);
}

void EncodePng(benchmark::State& state) {
  const Folder folder;
  fs::create_directories(folder.path);
  const CameraFrame picture = Picture(PixelCoding::kYuyv, 2);
  const Rgb8Image codes = DecodeCodes(picture.buffer.bytes, picture.buffer.layout).value();
  for (auto _ : state) WritePng(folder.path / "picture.png", codes);
}

void EncodeVideo(benchmark::State& state, VideoCodec codec) {
  const Folder folder;
  fs::create_directories(folder.path);
  const CameraFrame picture = Picture(PixelCoding::kYuyv, 2);
  const Rgb8Image codes = DecodeCodes(picture.buffer.bytes, picture.buffer.layout).value();
  VideoWriter writer(folder.path / "video.mkv", {codec, kWidth, kHeight, false, {}});
  std::chrono::milliseconds time{0};
  for (auto _ : state) writer.Add(codes, time += std::chrono::milliseconds(33));
}

BENCHMARK_CAPTURE(Record, yuyv_raw, PixelCoding::kYuyv, 2, PictureStore::kRaw)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(EncodePng)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Record, yuyv_ffv1, PixelCoding::kYuyv, 2, PictureStore::kFfv1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(EncodeVideo, ffv1, VideoCodec::kFfv1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Record, yuyv_h264, PixelCoding::kYuyv, 2, PictureStore::kH264)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(EncodeVideo, h264, VideoCodec::kH264)->Unit(benchmark::kMillisecond);
// Stored as it arrives, without an encoder.
BENCHMARK_CAPTURE(Record, bayer_raw, PixelCoding::kBayer, 1, PictureStore::kRaw)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();
