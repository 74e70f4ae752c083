// Times one estimate, and a textbook use of Ceres for the same samples beside it. Also counts, over
// 10^5 random problems, how many degenerate ones pass unflagged and how many sound ones do not.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include "estimation/light_change.h"
#include "estimation/lighting_fit.h"
#include "estimation/outdoor_lighting_source.h"
#include "estimation/sample_selection.h"
#include "tests/estimation/synthetic_scene.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair {
namespace {

using testing::MakeFrame;
using testing::MakeSamples;
using testing::MakeView;
using testing::Observe;
using testing::SyntheticPicture;
using testing::SyntheticPrior;
using testing::SyntheticScene;

// In an order like SampleSet's.
std::vector<DiffuseSample> OrderedSamples(int count) {
  SyntheticScene scene;
  scene.samples = count;
  scene.albedo_noise = 0.1;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (int i = 0; i < count; ++i) samples[static_cast<std::size_t>(i)].pixel = {i % 480, i / 480};
  return samples;
}

void FitSamples(benchmark::State& state, LightingFitOptions::Solver solver) {
  const std::vector<DiffuseSample> samples = OrderedSamples(static_cast<int>(state.range(0)));
  const LightingPrior prior = SyntheticPrior();
  LightingFitOptions options;
  options.solver = solver;
  LightingFitter fitter(options);
  int passes = 0;
  for (auto _ : state) {
    const LightingFit fit = fitter.Fit(samples, prior, true);
    benchmark::DoNotOptimize(fit);
    passes = fit.passes;
  }
  state.counters["passes"] = passes;
}
BENCHMARK_CAPTURE(FitSamples, Ceres, LightingFitOptions::Solver::kCeres)
    ->Arg(25)
    ->Arg(500)
    ->Arg(8000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(FitSamples, Closed, LightingFitOptions::Solver::kClosed)
    ->Arg(500)
    ->Unit(benchmark::kMicrosecond);

struct TextbookResidual {
  const DiffuseSample& sample;

  template <typename T>
  bool operator()(const T* light, T* residual) const {
    for (int c = 0; c < 3; ++c) {
      const T predicted =
          light[c] * sample.sun_transport_rgb[c] + light[3 + c] * sample.sky_transport_rgb[0][c];
      residual[c] = (predicted - sample.radiance_rgb[c]) / (0.1 * sample.radiance_rgb[c]);
    }
    return true;
  }
};

// One automatically differentiated block a sample, a robust loss, the covariance: no prior, no
// robust start, no shared errors.
void TextbookCeres(benchmark::State& state) {
  const std::vector<DiffuseSample> samples = OrderedSamples(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    std::array<double, 6> light{500.0, 500.0, 500.0, 100.0, 100.0, 100.0};
    ceres::Problem problem;
    for (const DiffuseSample& sample : samples) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<TextbookResidual, 3, 6>(new TextbookResidual{sample}),
          new ceres::TukeyLoss(8.0),
          light.data());
    }
    for (int u = 0; u < 6; ++u) problem.SetParameterLowerBound(light.data(), u, 0.0);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    ceres::Covariance::Options covariance_options;
    ceres::Covariance covariance(covariance_options);
    std::array<double, 36> matrix{};
    const std::vector<const double*> blocks{light.data()};
    covariance.Compute(blocks, &problem);
    covariance.GetCovarianceBlock(light.data(), light.data(), matrix.data());
    benchmark::DoNotOptimize(matrix);
  }
}
BENCHMARK(TextbookCeres)->Arg(500)->Unit(benchmark::kMicrosecond);

SyntheticPicture CameraPicture() {
  SyntheticPicture picture;
  picture.width = 480;
  picture.height = 360;
  picture.noise = 0.02;
  return picture;
}

// Adds the light of a clear and an overcast sky on the ground and a wall to the view's uniform one.
void AddSkyShapes(SurfaceView& view) {
  const Image<glm::vec3> uniform = view.sky_response[0];
  for (const auto& [name, on_wall] : {std::pair("overcast", 0.8f), std::pair("clear", 1.4f)}) {
    view.sky_shape_names.push_back(name);
    Image<glm::vec3>& response = view.sky_response.emplace_back(uniform);
    for (std::size_t i = 0; i < response.pixels.size(); ++i) {
      if (view.normal_world.pixels[i].z < 0.5f) response.pixels[i] *= on_wall;
    }
  }
}

// The change between two frames of 500 places each, by the places that both have.
void FindLightChange(benchmark::State& state) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  Lighting lighting;
  lighting.sun.irradiance_rgb = scene.sun;
  lighting.sky = {{"uniform", scene.sky}};
  std::array<std::vector<DiffuseSample>, 2> frames;
  for (std::vector<DiffuseSample>& frame : frames) {
    frame = MakeSamples(scene);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      // In no order, as places are that a camera moves past.
      frame[i].place_world_m = {static_cast<float>(i * 7919 % frame.size()), 0.0f, 0.0f};
    }
    scene.sun *= 0.8;
  }
  LightChangeWatch watch;
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(watch.Compare(frames[next++ % frames.size()], lighting));
  }
}
BENCHMARK(FindLightChange)->Unit(benchmark::kMicrosecond);

// From pixels to covariance, with the sample set kept. Arguments: samples, sky shapes. The frames
// differ by their noise, and after every 8th the light changes as behind a cloud. Each has just
// been written to the same place, as by a camera's decoder.
void EstimateFrame(benchmark::State& state) {
  SyntheticPicture picture = CameraPicture();
  SurfaceView view = MakeView(picture);
  if (state.range(1) > 1) AddSkyShapes(view);
  std::vector<Frame> frames;
  for (int i = 0; i < 16; ++i) {
    picture.seed = static_cast<std::uint64_t>(i);
    if (i == 8) picture.sun *= 0.3;
    frames.push_back(MakeFrame(picture, view));
  }
  OutdoorLightingOptions options;
  options.samples = static_cast<int>(state.range(0));
  const auto source = MakeOutdoorLightingSource(options);
  Frame frame = frames[0];
  std::size_t next = 0;
  std::vector<double> us;
  for (auto _ : state) {
    const Frame& read = frames[next++ % frames.size()];
    std::copy(
        read.radiance.pixels.begin(), read.radiance.pixels.end(), frame.radiance.pixels.begin());
    std::copy(
        read.unusable.pixels.begin(), read.unusable.pixels.end(), frame.unusable.pixels.begin());
    frame.time = frames[0].time + std::chrono::seconds(next);
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(source->Estimate(Observe(frame, view)));
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(spent.count());
    us.push_back(1e6 * spent.count());
  }
  std::nth_element(us.begin(), us.begin() + static_cast<std::ptrdiff_t>(us.size() / 2), us.end());
  state.counters["median_us"] = us[us.size() / 2];
}
BENCHMARK(EstimateFrame)
    ->ArgNames({"samples", "shapes"})
    ->Args({500, 1})
    ->Args({500, 3})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

void DrawSampleSet(benchmark::State& state) {
  const SyntheticPicture picture = CameraPicture();
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  SampleSet set;
  for (auto _ : state) {
    set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  }
}
BENCHMARK(DrawSampleSet)->Unit(benchmark::kMicrosecond);

// One iteration: 10^5 problems of each kind.
void FlagDegenerateProblems(benchmark::State& state) {
  constexpr int kProblems = 100000;
  LightingFitOptions options;
  options.solver = LightingFitOptions::Solver::kClosed;
  LightingFitter fitter(options);
  const glm::dvec3 beam = testing::SyntheticClearSky().beam_rgb;
  const double mean_beam = (beam.x + beam.y + beam.z) / 3.0;
  int missed = 0;
  int false_alarms = 0;
  for (auto _ : state) {
    std::mt19937_64 random(17);
    for (int i = 0; i < kProblems; ++i) {
      const testing::ProblemPair pair = testing::MakeProblemPair(random);
      if (DeterminesSun(fitter.Fit(MakeSamples(pair.degenerate), SyntheticPrior(), true),
                        mean_beam)) {
        ++missed;
      }
      if (!DeterminesSun(fitter.Fit(MakeSamples(pair.sound), SyntheticPrior(), true), mean_beam)) {
        ++false_alarms;
      }
    }
  }
  state.counters["degenerate_unflagged"] = missed;
  state.counters["sound_flagged"] = false_alarms;
}
BENCHMARK(FlagDegenerateProblems)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();
