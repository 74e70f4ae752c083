// Estimates the light of recorded frames by several sources, with one view for all of them.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <tl/expected.hpp>

#include "estimation/lighting_source.h"
#include "pipeline/sun_state.h"
#include "relight/prepared_scene.h"
#include "relight/surface_view_builder.h"
#include "scene/frame.h"
#include "scene/surface_view.h"
#include "sunmodel/site.h"

namespace pleinair {

// One source's estimate of one frame.
struct LightTrial {
  LightingEstimate estimate;
  double estimate_ms = 0.0;  // Without drawing a new sample set.
};

// One thread at a time.
class LightTrials {
 public:
  // `scene` outlives the trials. The sun's transport is computed on the raster of time of `run`.
  LightTrials(const PreparedScene& scene,
              std::optional<Site> site,
              const SurfaceViewOptions& options);

  // Returns one entry for each source, each of which may fail. The sky bases of `sources` have the
  // same shapes. Fails for all where the frame has no sun direction or no view.
  tl::expected<std::vector<tl::expected<LightTrial, LightingFailure>>, FrameError> Process(
      const Frame& frame, std::span<const std::unique_ptr<LightingSource>> sources);

  // The last frame's view, once it has an entry that has not failed.
  const SurfaceView& View() const { return *view_; }
  // Time to compute it.
  double ViewMs() const { return view_ms_; }

 private:
  const PreparedScene& scene_;
  std::optional<Site> site_;
  ScaledClearSky clear_sky_;
  SurfaceViewBuilder view_builder_;
  const SurfaceView* view_ = nullptr;
  double view_ms_ = 0.0;
};

}  // namespace pleinair
