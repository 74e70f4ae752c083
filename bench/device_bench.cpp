// Frames where a GPU draws them, and whether its pictures are those of a machine without one. The
// recorded courtyard's frame 6 in three sizes, from a camera that stands still and from one that is
// held in the hand, with its light kept on the surfaces. Files are read in advance.
//
//   pleinair_device_bench [--out FOLDER] [--reference FOLDER]
//
// Prints medians over frames, in ms: the entire frame, its view, its drawing, the time from the
// first to the last command of that by the device's own clock (0 where the processor composites),
// and reading back. `--out` writes the last picture of each row as PNG. `--reference` takes such a
// folder, of another machine, and prints the share of the changed pixels that differ by more than
// one code value in some channel, and the largest difference. Exits with 1 where more than 0.1 %
// do, with 2 on errors.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/mat4x4.hpp>

#include "bench/recorded_courtyard.h"
#include "bench/resized_frame.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/display_codes.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "scene/image_io.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

struct Row {
  int width_px = 0;
  int height_px = 0;
  bool is_hand_held = false;

  std::string Name() const {
    return std::to_string(width_px) + "x" + std::to_string(height_px) +
           (is_hand_held ? "-hand-held" : "-still");
  }
};

struct Times {
  std::vector<double> frame_ms;
  std::vector<double> view_ms;
  std::vector<double> draw_ms;
  std::vector<double> device_ms;
  std::vector<double> read_back_ms;
};

Rgb8Image CodesOf(const RgbImage& radiance, const DisplayCodes& codes) {
  Rgb8Image picture(radiance.width, radiance.height);
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      picture.pixels[i][c] =
          static_cast<std::uint8_t>(std::lround(codes.Code(c, radiance.pixels[i][c])));
    }
  }
  return picture;
}

// The last picture of a row.
struct Picture {
  Rgb8Image codes;
  std::size_t changed = 0;  // Pixels that are not the camera's.
};

Picture Run(const RecordedCourtyard& yard, const Row& row, Times& times) {
  constexpr int kFrames = 30;
  constexpr int kWarmUp = 6;
  Frame frame = yard.frame;
  if (row.width_px != frame.radiance.width) Resize(row.width_px, row.height_px, frame);
  const glm::dmat4 first_pose = frame.camera.camera_from_world;
  Compositor compositor;
  FramePipelineOptions options;
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  options.influence_at = InfluenceAt::kFaces;
  FramePipeline pipeline({yard.scene, yard.site.model.mesh, yard.sequence.site, yard.site.objects},
                         MakeOutdoorLightingSource({}),
                         compositor,
                         options);
  Composite last;
  for (int i = 0; i < kFrames; ++i) {
    if (row.is_hand_held) frame.camera.camera_from_world = HeldInTheHand(first_pose, i);
    const auto start = std::chrono::steady_clock::now();
    auto result = pipeline.Process(frame);
    const std::chrono::duration<double, std::milli> whole =
        std::chrono::steady_clock::now() - start;
    if (!result) throw std::runtime_error(row.Name() + ": " + result.error().reason);
    if (i >= kWarmUp) {
      times.frame_ms.push_back(whole.count());
      times.view_ms.push_back(result->timing_ms.transport);
      times.draw_ms.push_back(result->timing_ms.render);
      times.device_ms.push_back(result->composite.device_ms);
      times.read_back_ms.push_back(result->timing_ms.readback);
    }
    last = std::move(result->composite);
  }
  const auto unchanged =
      std::count(last.change.pixels.begin(), last.change.pixels.end(), std::uint8_t{0});
  return {
      CodesOf(last.radiance, DisplayCodes(ResponseCurve::Srgb(), ChosenExposure(frame.radiance))),
      last.change.pixels.size() - static_cast<std::size_t>(unchanged)};
}

struct Difference {
  double share = 0.0;  // Of changed pixels that differ by more than one code value.
  int largest = 0;
};

Difference Compare(const Picture& drawn, const std::filesystem::path& reference_file) {
  const Rgb8Image& picture = drawn.codes;
  const Rgb8Image reference = ReadDisplayImage(reference_file);
  if (reference.width != picture.width || reference.height != picture.height) {
    throw std::runtime_error(reference_file.string() + ": is " + std::to_string(reference.width) +
                             "x" + std::to_string(reference.height) + ", expected " +
                             std::to_string(picture.width) + "x" + std::to_string(picture.height));
  }
  Difference difference;
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    int most = 0;
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(picture.pixels[i][c] - reference.pixels[i][c]));
    }
    if (most > 1) ++count;
    difference.largest = std::max(difference.largest, most);
  }
  difference.share =
      static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(drawn.changed, 1));
  return difference;
}

struct Folders {
  std::optional<std::filesystem::path> out;
  std::optional<std::filesystem::path> reference;
};

Folders FoldersOf(int argc, char** argv) {
  Folders folders;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    if (name == "--out") folders.out = argv[i + 1];
    if (name == "--reference") folders.reference = argv[i + 1];
  }
  const std::size_t given = (folders.out ? 2u : 0u) + (folders.reference ? 2u : 0u);
  if (given + 1 != static_cast<std::size_t>(argc)) {
    throw std::runtime_error(
        "usage: pleinair_device_bench [--out FOLDER] [--reference FOLDER], each at most once");
  }
  return folders;
}

// Returns whether all pictures are the reference's.
bool RunAll(const Folders& folders) {
  if (!std::filesystem::exists(kRecordedCourtyard)) {
    throw std::runtime_error(kRecordedCourtyard.string() + ": the recorded courtyard is not there");
  }
  if (folders.reference && !std::filesystem::is_directory(*folders.reference)) {
    throw std::runtime_error(folders.reference->string() +
                             ": is no folder, expected one that --out wrote");
  }
  if (folders.out) std::filesystem::create_directories(*folders.out);
  const HeadlessContext context;
  const GlDescription gl = context.Describe();
  std::printf("%s, %s\n", gl.renderer.c_str(), gl.version.c_str());
  std::printf("%-20s %8s %8s %8s %8s %8s", "ms", "frame", "view", "draw", "device", "read");
  std::printf(folders.reference ? "  differ %%   most\n" : "\n");
  const RecordedCourtyard yard;
  bool is_same = true;
  for (const bool is_hand_held : {false, true}) {
    for (const auto& [width_px, height_px] :
         {std::pair{480, 360}, std::pair{1280, 720}, std::pair{1920, 1080}}) {
      const Row row{width_px, height_px, is_hand_held};
      Times times;
      const Picture picture = Run(yard, row, times);
      std::printf("%-20s %8.1f %8.1f %8.1f %8.2f %8.2f",
                  row.Name().c_str(),
                  UpperMedian(times.frame_ms),
                  UpperMedian(times.view_ms),
                  UpperMedian(times.draw_ms),
                  UpperMedian(times.device_ms),
                  UpperMedian(times.read_back_ms));
      if (folders.out) WritePng(*folders.out / (row.Name() + ".png"), picture.codes);
      if (folders.reference) {
        const Difference difference = Compare(picture, *folders.reference / (row.Name() + ".png"));
        std::printf("  %8.4f %6d", 100.0 * difference.share, difference.largest);
        if (difference.share > 1e-3) is_same = false;
      }
      std::printf("\n");
      std::fflush(stdout);
    }
  }
  return is_same;
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  try {
    return pleinair::RunAll(pleinair::FoldersOf(argc, argv)) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
