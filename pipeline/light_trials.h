// The light of recorded frames as many sources find it, each frame's view made once for all.
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

struct LightTrial {
  LightingEstimate estimate;
  double estimate_ms = 0.0;  // Without the drawing of a new sample set.
};

class LightTrials {
 public:
  // `scene` outlives the trials. The sun's transport is made on the raster of time that `run` has.
  LightTrials(const PreparedScene& scene,
              std::optional<Site> site,
              const SurfaceViewOptions& options);

  // One entry a source, which may fail by itself. The sky bases of `sources` are of the same
  // shapes. Fails for all where the frame has no sun direction or no view.
  tl::expected<std::vector<tl::expected<LightTrial, LightingFailure>>, FrameError> Process(
      const Frame& frame, std::span<const std::unique_ptr<LightingSource>> sources);

  // The last frame's, once it has an entry that has not failed.
  const SurfaceView& View() const { return *view_; }
  // What it cost.
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
