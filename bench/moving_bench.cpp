// Objects in motion, lit in steps: the time of a frame, the error of its picture and of a still
// object's against the converged one, and the time until the light is complete. The recorded
// courtyard at 640x480, with its statue of 4000 or 15000 faces; the recorded room at 512x496, with
// its own object. An object moves by half a centimetre a frame (`going`) or also turns by two
// degrees (`turning`), 25 frames a second; in the room the camera moves by as much, and the sky is
// a new picture in every frame (`room/all`). Files are read in advance, nothing is written.
//
//   pleinair_moving_bench [Google Benchmark's options]
//
// `median_ms` is a frame in motion, `cpu_ms` its processor time (all threads together);
// `rest_frames` come after it until the light is complete, and take `rest_ms` in all, at most
// `rest_most_ms` each. Of the last frame in motion, against many rays: `object_db`, `surfaces_db`
// and, of both together, `all_db` are decibels of white; `object_still_db` and so on those of the
// complete picture; `object_half_second_db` and so on those of the last picture within half a
// second of rest.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "bench/cut_mesh.h"
#include "bench/processor_time.h"
#include "bench/recorded_place.h"
#include "bench/resized_frame.h"
#include "datasets/fisheye_setup.h"
#include "datasets/sequence.h"
#include "estimation/fisheye_lighting_source.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/display_codes.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "scene/mesh_io.h"
#include "scene/upper_median.h"
#include "session/sequence_site.h"

namespace pleinair {
namespace {

const std::filesystem::path kSequences = std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences";

struct Place : RecordedPlace {
  std::filesystem::path folder;

  Place(const char* name, int frame_index, int width_px, int height_px)
      : RecordedPlace(kSequences / name, frame_index), folder(kSequences / name) {
    Resize(width_px, height_px, frame);
  }
};

// Estimates as outdoors, then returns fixed intensities, which do not depend on earlier frames.
class Given : public LightingSource {
 public:
  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    return source_->BasisFor(frame, sun);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    auto estimate = source_->Estimate(observation);
    if (!estimate) return estimate;
    estimate->lighting.sun.irradiance_rgb = glm::dvec3(1000.0, 950.0, 830.0);
    for (SkyComponent& sky : estimate->lighting.sky) {
      sky.irradiance_rgb = glm::dvec3(50.0, 60.0, 80.0);
    }
    return estimate;
  }

 private:
  std::unique_ptr<LightingSource> source_ = MakeOutdoorLightingSource({});
};

struct Moves {
  double turn_rad = 0.0;  // A frame, about the vertical through the object's middle.
  bool camera = false;
  bool sky = false;
};

// The scene in front of the camera, and its later frames.
struct Show {
  const Place& place;
  std::vector<VirtualObject> objects;
  FramePipelineOptions options;
  Moves moves;

  std::unique_ptr<LightingSource> Source() const {
    if (!place.sequence.fisheye) return std::make_unique<Given>();
    return MakeFisheyeLightingSource(MakeFisheyeSetup(*place.sequence.fisheye, place.folder).camera,
                                     {});
  }

  Frame FrameAt(int step, int time_step) const {
    Frame frame = place.frame;
    frame.time += std::chrono::milliseconds(40 * time_step);
    if (moves.camera) {
      frame.camera.camera_from_world =
          glm::translate(glm::dmat4(1.0), glm::dvec3(-0.005 * step, 0.0, 0.0)) *
          glm::rotate(glm::dmat4(1.0), 1e-3 * step, glm::dvec3(0.0, 1.0, 0.0)) *
          frame.camera.camera_from_world;
    }
    if (moves.sky) {
      // One half of the sky brighter or darker than it was.
      RgbImage& sky = *frame.fisheye_radiance;
      const float scale = 1.0f + 0.3f * std::sin(0.1f * static_cast<float>(step));
      for (int y = 0; y < sky.height; ++y) {
        for (int x = 0; x < sky.width / 2; ++x) sky.At(x, y) *= scale;
      }
    }
    return frame;
  }

  std::vector<glm::dmat4> PosesAt(int step) const {
    BoundingBox box = BoundingBoxOf(objects.front().mesh);
    const glm::dvec3 middle_m(0.5f * (box.lower_m + box.upper_m));
    const glm::dvec3 going_m(0.005 * step, 0.0, 0.0);
    return std::vector<glm::dmat4>(
        objects.size(),
        glm::translate(glm::dmat4(1.0), middle_m + going_m) *
            glm::rotate(glm::dmat4(1.0), moves.turn_rad * step, glm::dvec3(0.0, 0.0, 1.0)) *
            glm::translate(glm::dmat4(1.0), -middle_m));
  }
};

// A pipeline and the context that it draws in.
class Drawing {
 public:
  Drawing(const Show& show, const FramePipelineOptions& options)
      : show_(show),
        pipeline_(
            {show.place.scene, show.place.site.model.mesh, show.place.sequence.site, show.objects},
            show.Source(),
            compositor_,
            options) {}
  FrameResult Take(int step, int time_step) {
    return pipeline_.Process(show_.FrameAt(step, time_step), show_.PosesAt(step)).value();
  }

 private:
  const Show& show_;
  HeadlessContext context_;
  Compositor compositor_;
  FramePipeline pipeline_;
};

struct Decibels {
  double object = 0.0;
  double surfaces = 0.0;
  double all = 0.0;
};

Decibels Compare(const Composite& composite, const Composite& reference, const Frame& frame) {
  const DisplayCodes codes(ResponseCurve::Srgb(),
                           frame.exposure.value_or(ChosenExposure(frame.radiance)));
  double sum[2] = {0.0, 0.0};
  double count[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < reference.radiance.pixels.size(); ++i) {
    // Pixels at an edge of the object in only one of the pictures differ by more than light.
    if (reference.change.pixels[i] == 0 || reference.change.pixels[i] != composite.change.pixels[i])
      continue;
    const bool is_object =
        reference.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered);
    for (int channel = 0; channel < 3; ++channel) {
      const double off = codes.Code(channel, composite.radiance.pixels[i][channel]) -
                         codes.Code(channel, reference.radiance.pixels[i][channel]);
      sum[is_object] += off * off;
      count[is_object] += 1.0;
    }
  }
  const auto decibels = [](double squares, double of) {
    return 10.0 * std::log10(kWhiteCode * kWhiteCode * of / squares);
  };
  return {decibels(sum[1], count[1]),
          decibels(sum[0], count[0]),
          decibels(sum[0] + sum[1], count[0] + count[1])};
}

void Run(benchmark::State& state, const Show& show) {
  using Clock = std::chrono::steady_clock;
  FramePipelineOptions converged = show.options;
  converged.light_in_steps = false;
  converged.object_light.gather.rays_per_receiver = 2048;
  converged.influence.rays_per_receiver = 1536;
  FramePipelineOptions at_once = show.options;
  at_once.light_in_steps = false;
  int step = 0;
  int time_step = 0;
  FrameResult last;
  std::vector<double> moving_ms;
  constexpr double kHalfASecondMs = 500.0;
  std::vector<double> rest_ms;
  double rest_sum_ms = 0.0;
  Composite after_half_a_second;
  std::map<std::string, std::vector<double>> stages_ms;
  {
    Drawing drawing(show, show.options);
    const auto take = [&](std::vector<double>& times_ms) {
      const auto start = Clock::now();
      FrameResult result = drawing.Take(step, ++time_step);
      times_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      return result;
    };
    std::vector<double> first_ms;
    take(first_ms);
    for (auto _ : state) {
      ++step;
      const double cpu_before_ms = ProcessorMs();
      last = take(moving_ms);
      stages_ms["cpu_ms"].push_back(ProcessorMs() - cpu_before_ms);
      stages_ms["view_ms"].push_back(last.timing_ms.transport);
      stages_ms["light_ms"].push_back(last.timing_ms.estimate);
      stages_ms["draw_ms"].push_back(last.timing_ms.render + last.timing_ms.readback);
      for (const PlannedWork& work : last.works) {
        if (work.is_done && !work.is_drawing) stages_ms[std::string(work.name)].push_back(work.ms);
      }
    }
    const int last_time_step = time_step;
    for (bool is_coarse = true; is_coarse && rest_ms.size() < 200;) {
      FrameResult resting = take(rest_ms);
      rest_sum_ms += rest_ms.back();
      is_coarse = resting.is_light_coarse;
      if (rest_sum_ms <= kHalfASecondMs) after_half_a_second = std::move(resting.composite);
    }
    time_step = last_time_step;
  }
  const Frame frame = show.FrameAt(step, time_step);
  const FrameResult reference = Drawing(show, converged).Take(step, time_step);
  if (after_half_a_second.change.Empty()) after_half_a_second = last.composite;
  const Decibels half_second = Compare(after_half_a_second, reference.composite, frame);
  const Decibels moving = Compare(last.composite, reference.composite, frame);
  const Decibels still =
      Compare(Drawing(show, at_once).Take(step, time_step).composite, reference.composite, frame);
  for (const auto& [name, values] : stages_ms) state.counters[name] = UpperMedian(values);
  state.counters["median_ms"] = UpperMedian(moving_ms);
  state.counters["rest_frames"] = static_cast<double>(rest_ms.size());
  state.counters["rest_ms"] = rest_sum_ms;
  state.counters["rest_most_ms"] = *std::max_element(rest_ms.begin(), rest_ms.end());
  state.counters["object_db"] = moving.object;
  state.counters["object_half_second_db"] = half_second.object;
  state.counters["object_still_db"] = still.object;
  state.counters["surfaces_db"] = moving.surfaces;
  state.counters["surfaces_half_second_db"] = half_second.surfaces;
  state.counters["surfaces_still_db"] = still.surfaces;
  state.counters["all_db"] = moving.all;
  state.counters["all_half_second_db"] = half_second.all;
  state.counters["all_still_db"] = still.all;
}

FramePipelineOptions InSteps() {
  FramePipelineOptions options;
  options.filter.reset();
  options.light_in_steps = true;
  return options;
}

constexpr double kTurnRad = 2.0 * std::numbers::pi / 180.0;

void RunYard(benchmark::State& state, std::size_t faces, const Moves& moves) {
  static const Place yard("courtyard-clouds", 7, 640, 480);
  // Unchanged from its file: `run` would cut its large faces.
  const VirtualObjectEntry& statue = yard.sequence.virtual_objects.at(0);
  Mesh mesh = WithTriangles(
      TransformMesh(statue.world_from_object, LoadMesh(yard.folder / statue.mesh).mesh), faces);
  Run(state, {yard, {{std::move(mesh)}}, InSteps(), moves});
}

void RunRoom(benchmark::State& state, const Moves& moves) {
  static const Place room("room-window", 5, 512, 496);
  FramePipelineOptions options = InSteps();
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  options.view.sun_block_px = 4;
  options.influence_at = InfluenceAt::kFaces;
  Run(state, {room, room.site.objects, options, moves});
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  using namespace pleinair;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const auto add = [](const std::string& name, auto run) {
    benchmark::RegisterBenchmark(name.c_str(), run)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Iterations(40);
  };
  if (std::filesystem::exists(kSequences)) {
    for (const std::size_t faces : {4000, 15000}) {
      for (const double turn_rad : {0.0, kTurnRad}) {
        add("yard/" + std::to_string(faces) + (turn_rad > 0.0 ? "/turning" : "/going"),
            [=](benchmark::State& state) { RunYard(state, faces, {.turn_rad = turn_rad}); });
      }
    }
    add("room/going", [](benchmark::State& state) { RunRoom(state, {}); });
    add("room/turning", [](benchmark::State& state) { RunRoom(state, {.turn_rad = kTurnRad}); });
    add("room/camera", [](benchmark::State& state) { RunRoom(state, {.camera = true}); });
    add("room/all", [](benchmark::State& state) { RunRoom(state, {.camera = true, .sky = true}); });
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
