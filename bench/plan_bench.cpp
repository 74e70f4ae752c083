// The whole frame at 640x480, with the plan and with everything on, under light that calls for more
// or less: the recorded courtyard and its statue of 7204 faces, or cut to four times as many. The
// camera stands still and time goes on by a second a frame; files are read before and nothing is
// written.
//
//   pleinair_plan_bench [Google Benchmark's options]
//
// `median_ms` is of the whole frame; the mean has the sun's steps in it.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "apps/file_blob_store.h"
#include "apps/sequence_site.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "scene/mesh_io.h"

namespace pleinair {
namespace {

enum class Under { kSun, kSunNoShadow, kCloud, kNight, kSunOutOfSight };

const std::filesystem::path kCourtyard =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";

// Estimates as outdoors, and then says what the bench wants.
class Staged : public LightingSource {
 public:
  explicit Staged(Under under) : under_(under) {}
  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    return source_->BasisFor(frame, sun);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    auto estimate = source_->Estimate(observation);
    if (!estimate) return estimate;
    const bool is_sunny = under_ != Under::kCloud && under_ != Under::kNight;
    estimate->lighting.sun.irradiance_rgb =
        is_sunny ? glm::dvec3(1000.0, 950.0, 830.0) : glm::dvec3(0.0);
    for (SkyComponent& sky : estimate->lighting.sky) {
      sky.irradiance_rgb = under_ == Under::kNight ? glm::dvec3(0.0) : glm::dvec3(50.0, 60.0, 80.0);
    }
    return estimate;
  }

 private:
  Under under_;
  std::unique_ptr<LightingSource> source_ = MakeOutdoorLightingSource({});
};

struct Yard {
  Sequence sequence = ReadSequence(kCourtyard);
  SequenceSite site = LoadSequenceSite(sequence);
  PreparedScene scene;
  Frame frame;  // Of 640x480, in the sun.

  Yard() {
    FileBlobStore store;
    scene = PrepareScene(site.model, PrepareOptionsFor(site), store, [](auto, auto) {});
    const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
    for (int i = 0; i < 8; ++i) frame = frames->Next()->value();
    CameraIntrinsics& lens = frame.camera.intrinsics;
    const double scale = 640.0 / lens.width_px;
    lens = {.width_px = 640,
            .height_px = 480,
            .fx_px = lens.fx_px * scale,
            .fy_px = lens.fy_px * scale,
            .cx_px = 319.5,
            .cy_px = 239.5};
    const RgbImage recorded = frame.radiance;
    frame.radiance = RgbImage(640, 480);
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        frame.radiance.At(x, y) = recorded.At(x * recorded.width / 640, y * recorded.height / 480);
      }
    }
    frame.clipped = Gray8Image(640, 480, 0);
    frame.unusable = Gray8Image(640, 480, 0);
  }
};

// Each triangle becomes four.
Mesh CutInFour(const Mesh& mesh) {
  Mesh cut = mesh;
  cut.triangles.clear();
  cut.triangle_material.clear();
  cut.triangle_group.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    const auto first = static_cast<std::uint32_t>(cut.positions_m.size());
    for (int edge = 0; edge < 3; ++edge) {
      const std::uint32_t a = v[edge];
      const std::uint32_t b = v[(edge + 1) % 3];
      cut.positions_m.push_back(0.5f * (mesh.positions_m[a] + mesh.positions_m[b]));
      cut.normals.push_back(glm::normalize(mesh.normals[a] + mesh.normals[b]));
    }
    cut.triangles.insert(cut.triangles.end(),
                         {{v.x, first, first + 2},
                          {first, v.y, first + 1},
                          {first + 2, first + 1, v.z},
                          {first, first + 1, first + 2}});
    for (int part = 0; part < 4; ++part) {
      cut.triangle_material.push_back(mesh.triangle_material[t]);
      cut.triangle_group.push_back(mesh.triangle_group[t]);
    }
  }
  return cut;
}

void RunFrames(benchmark::State& state, Under under, bool planned, bool fine) {
  if (!std::filesystem::exists(kCourtyard)) {
    state.SkipWithError("the recorded courtyard is not there");
    return;
  }
  static const Yard yard;
  // As its file has it: `run` would cut its large faces.
  const VirtualObjectEntry& statue = yard.sequence.virtual_objects.at(0);
  Mesh mesh = TransformMesh(statue.world_from_object, LoadMesh(kCourtyard / statue.mesh).mesh);
  if (fine) mesh = CutInFour(mesh);
  const std::size_t faces = mesh.triangles.size();
  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.filter.reset();
  if (!planned) options.effects = EffectSettings::Everything();
  if (under == Under::kSunNoShadow) {
    options.effects[Effect::kSunShadow] = EffectSwitch::kOff;
    options.effects[Effect::kObjectShadow] = EffectSwitch::kOff;
    options.effects[Effect::kPenumbra] = EffectSwitch::kOff;
  }
  FramePipeline pipeline(yard.scene,
                         yard.site.model.mesh,
                         yard.sequence.site,
                         {{std::move(mesh)}},
                         std::make_unique<Staged>(under),
                         compositor,
                         options);
  std::vector<glm::dmat4> poses;
  if (under == Under::kSunOutOfSight) {
    poses = {glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, -2000.0, 0.0))};
  }
  Frame frame = yard.frame;
  if (under == Under::kNight) frame.radiance = RgbImage(640, 480, glm::vec3(1e-6f));
  for (int i = 0; i < 2; ++i) {
    frame.time += std::chrono::seconds(1);
    if (const auto first = pipeline.Process(frame, poses); !first) {
      state.SkipWithError(first.error().reason.c_str());
      return;
    }
  }
  std::vector<double> whole_ms;
  double planning_ms = 0.0;
  double draw_ms = 0.0;
  int draw_calls = 0;
  for (auto _ : state) {
    frame.time += std::chrono::seconds(1);
    const auto start = std::chrono::steady_clock::now();
    const auto result = pipeline.Process(frame, poses);
    whole_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
    benchmark::DoNotOptimize(result->composite.radiance.pixels.data());
    planning_ms += result->planning_ms;
    draw_ms += result->composite.draw_ms;
    draw_calls = result->composite.draw_calls;
  }
  const auto middle = whole_ms.begin() + static_cast<std::ptrdiff_t>(whole_ms.size() / 2);
  std::nth_element(whole_ms.begin(), middle, whole_ms.end());
  const auto mean = [&](double sum) {
    return benchmark::Counter(sum, benchmark::Counter::kAvgIterations);
  };
  state.counters["median_ms"] = *middle;
  state.counters["draw_ms"] = mean(draw_ms);
  state.counters["planning_ms"] = mean(planning_ms);
  state.counters["draw_calls"] = draw_calls;
  state.counters["faces"] = static_cast<double>(faces);
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  using pleinair::Under;
  constexpr int kIterations = 96;  // Two steps of the sun's raster.
  for (const auto& [name, under] : {std::pair{"sun", Under::kSun},
                                    std::pair{"sun_without_shadows", Under::kSunNoShadow},
                                    std::pair{"cloud", Under::kCloud},
                                    std::pair{"night", Under::kNight},
                                    std::pair{"out_of_sight", Under::kSunOutOfSight}}) {
    for (const bool fine : {false, true}) {
      for (const bool planned : {true, false}) {
        benchmark::RegisterBenchmark(
            (std::string(name) + (fine ? "/fine" : "/coarse") + (planned ? "/plan" : "/all"))
                .c_str(),
            [under = under, planned, fine](benchmark::State& state) {
              pleinair::RunFrames(state, under, planned, fine);
            })
            ->Unit(benchmark::kMillisecond)
            ->MeasureProcessCPUTime()
            ->UseRealTime()
            ->Iterations(kIterations);
      }
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
