#include "pipeline/light_trials.h"

#include <chrono>
#include <exception>
#include <string>

#include "pipeline/frame_pipeline.h"
#include "pipeline/frame_view.h"
#include "pipeline/internal/observation.h"
#include "scene/elapsed.h"

namespace pleinair {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

LightTrials::LightTrials(const PreparedScene& scene,
                         std::optional<Site> site,
                         const SurfaceViewOptions& options)
    : scene_(scene),
      site_(site),
      clear_sky_(site_, scene.survey ? &scene.survey->light : nullptr),
      view_builder_(scene, options) {}

tl::expected<std::vector<tl::expected<LightTrial, LightingFailure>>, FrameError>
LightTrials::Process(const Frame& frame, std::span<const std::unique_ptr<LightingSource>> sources) {
  const auto failed = [&](std::string reason) {
    return tl::unexpected(FrameError{frame.index, frame.time, std::move(reason)});
  };
  std::vector<tl::expected<LightTrial, LightingFailure>> trials;
  try {
    const SunState sun = SunOfFrame(site_, frame);
    const FramePipelineOptions usual;
    const TransportTime transport =
        TransportSun(site_, frame, sun, {usual.sun_step_s, usual.bounce_step_s});
    view_ = nullptr;
    for (const std::unique_ptr<LightingSource>& source : sources) {
      const auto basis = source->BasisFor(frame, transport.bounces);
      if (!basis) {
        trials.push_back(tl::unexpected(basis.error()));
        continue;
      }
      if (view_ == nullptr) {
        const auto start = Clock::now();
        view_ =
            &view_builder_.Update(frame.camera, transport.Place(), *basis, SampleRegionsOf(frame));
        view_ms_ = MsSince(start);
      }
      const auto start = Clock::now();
      auto estimate = source->Estimate(Observe(scene_, clear_sky_, frame, *view_, sun));
      const double spent_ms = MsSince(start);
      if (!estimate) {
        trials.push_back(tl::unexpected(estimate.error()));
        continue;
      }
      const double draw_ms = estimate->new_sample_set_ms;
      trials.push_back(LightTrial{std::move(*estimate), spent_ms - draw_ms});
    }
  } catch (const std::exception& error) {
    return failed(error.what());
  }
  return trials;
}

}  // namespace pleinair
