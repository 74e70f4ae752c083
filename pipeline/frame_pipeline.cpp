#include "pipeline/frame_pipeline.h"

#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

#include "estimation/outdoor_estimator.h"
#include "pipeline/daylight_colours.h"
#include "pipeline/frame_view.h"
#include "pipeline/internal/frame_effects.h"
#include "pipeline/internal/observation.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

const SurveyLight* LightOf(const PreparedScene& scene) {
  return scene.survey ? &scene.survey->light : nullptr;
}

// Without its intensity.
DirectionalLight LightOf(const SunState& sun) {
  return {sun.direction_enu, {}, sun.angular_radius_rad};
}

// Steps are counted in nanoseconds since 1970.
void RequireStep(const char* name, double step_s) {
  constexpr double kLeastS = 1e-3;
  constexpr double kMostS = 86400.0;
  if (step_s == 0.0 || (step_s >= kLeastS && step_s <= kMostS)) return;
  std::ostringstream text;
  text << name << ' ' << step_s << ": expected 0, or " << kLeastS << " to " << kMostS << " seconds";
  throw std::invalid_argument(text.str());
}

}  // namespace

void FramePipelineOptions::Validate() const {
  RequireStep("sun_step_s", sun_step_s);
  RequireStep("bounce_step_s", bounce_step_s);
  object_light.Validate();
  influence.Validate();
  effects.Validate();
  soft_sun.Validate();
  mirror.Validate();
  camera_matching.Validate();
  motion_blur.Validate();
}

FramePipeline::FramePipeline(CompositedScene scene,
                             std::unique_ptr<LightingSource> source,
                             Compositor& compositor,
                             const FramePipelineOptions& options)
    : scene_(scene.scene),
      site_(scene.site),
      compositor_(compositor),
      objects_(std::move(scene.objects)),
      source_(std::move(source)),
      options_(options),
      clear_sky_(site_, LightOf(scene_)),
      view_builder_(scene_, options.view) {
  options_.Validate();
  if (options_.filter) filter_.emplace(*options_.filter);
  effects_ = std::make_unique<FrameEffects>(scene_, scene.phantom, objects_, compositor_, options_);
}

FramePipeline::~FramePipeline() = default;

tl::expected<FrameResult, FrameError> FramePipeline::Process(
    const Frame& frame, std::span<const glm::dmat4> object_poses) {
  const auto failed = [&](std::string reason) {
    return tl::unexpected(FrameError{frame.index, frame.time, std::move(reason)});
  };
  try {
    Stopwatch watch;
    FrameResult result;
    objects_.Pose(object_poses);
    result.sun = SunOfFrame(site_, frame);
    result.clear_sky = clear_sky_.At(result.sun.direction_enu);
    const TransportTime& transport = TransportOf(frame, result.sun);
    result.sun_age_s = std::chrono::duration<double>(frame.time - transport.time).count();

    const auto basis = source_->BasisFor(frame, transport.bounces);
    if (!basis) return failed(basis.error().reason);
    sky_shapes_.assign(basis->begin(), basis->end());
    const std::optional<ViewPart> part = PartLookedAt(frame);
    const SurfaceView& view = view_builder_.Update(frame.camera,
                                                   transport.Place(),
                                                   sky_shapes_,
                                                   SampleRegionsOf(frame),
                                                   part ? &*part : nullptr);
    const LightingObservation observation = Observe(scene_, clear_sky_, frame, view, result.sun);
    if (!view.is_whole && !source_->IsServedBy(observation)) view_builder_.WholeView();
    if (options_.sun_ahead) MakeSunAhead(frame);
    result.timing_ms.transport = watch.LapMs();

    auto estimate = source_->Estimate(observation);
    if (!estimate) return failed(estimate.error().reason);
    result.estimate = std::move(*estimate);
    FilterEstimate(result);
    result.timing_ms.estimate = watch.LapMs() - result.estimate.new_sample_set_ms;
    result.timing_ms.transport += result.estimate.new_sample_set_ms;

    ChooseDrawnLight(result);
    Draw(frame, result);
    return result;
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

tl::expected<FrameResult, FrameError> FramePipeline::Redraw(
    const Frame& frame, const FrameLight& light, std::span<const glm::dmat4> object_poses) {
  try {
    objects_.Pose(object_poses);
    view_builder_.WholeView();
    FrameResult result;
    static_cast<FrameLight&>(result) = light;
    Draw(frame, result);
    return result;
  } catch (const std::exception& error) {
    return tl::unexpected(FrameError{frame.index, frame.time, error.what()});
  }
}

std::optional<ViewPart> FramePipeline::PartLookedAt(const Frame& frame) {
  // Trackers repeat a pose until they have the next one.
  constexpr int kMostFramesInPlace = 3;
  const SurfaceView& last = view_builder_.View();
  // With polygons no view is made in part.
  if (!last.geometry_id.IsSet() || !frame.sample_polygons.empty()) return std::nullopt;
  frames_in_place_ = last.camera == frame.camera ? frames_in_place_ + 1 : 0;
  const bool may_be_part =
      frames_in_place_ == 0 || (!last.is_whole && frames_in_place_ <= kMostFramesInPlace);
  if (!may_be_part) return std::nullopt;
  std::optional<LookedAtPlaces> places =
      effects_->PlacesLookedAt(frame, LightOf(transport_.value().sun));
  if (!places) return std::nullopt;
  std::optional<std::vector<PixelRect>> rects = source_->PixelsLookedAt(frame.camera);
  if (!rects) return std::nullopt;
  return ViewPart{std::move(*rects), std::move(*places)};
}

void FramePipeline::Draw(const Frame& frame, FrameResult& result) {
  const DirectionalLight transport_sun = LightOf(transport_.value().sun);
  const DirectionalLight bounce_sun = LightOf(transport_.value().bounces);
  const Lighting& lighting = result.DrawnLighting();
  const StageTimes before = result.timing_ms;
  static_cast<RenderedFrame&>(result) = effects_->Render({frame,
                                                          result.estimate.response,
                                                          view_builder_.View(),
                                                          view_builder_,
                                                          transport_sun,
                                                          bounce_sun,
                                                          lighting,
                                                          before.estimate});
  result.timing_ms.transport += before.transport;
  result.timing_ms.estimate = before.estimate;
}

void FramePipeline::SetEffects(const EffectSettings& effects) {
  effects.Validate();
  options_.effects = effects;
  effects_->SetEffects(effects);
}

void FramePipeline::SetObjects(std::vector<VirtualObject> objects, const Mesh& phantom) {
  objects_ = PosedObjects(std::move(objects));
  effects_ = std::make_unique<FrameEffects>(scene_, phantom, objects_, compositor_, options_);
}

const IrradianceVolume& FramePipeline::Volume() const { return effects_->Volume(); }

RgbImage FramePipeline::EnvironmentRadiance(const EnvironmentView& view,
                                            const Lighting& lighting) const {
  const FaceLight& sun = view_builder_.SunFaces();
  std::vector<EnvironmentLight> basis{{nullptr, sun.radiosity, sun.direct_irradiance}};
  const auto shapes = view_builder_.SkyShapes();
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    basis.push_back({shapes[k].get(), view_builder_.SkyFaces(k).radiosity, {}});
  }
  return view.Radiance(lighting, basis);
}

RgbImage FramePipeline::SkyRadiance(const Lighting& lighting, LatLongSize size) const {
  RgbImage sky(size.width, size.height, glm::vec3(0.0f));
  tbb::parallel_for(0, size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
      if (!(direction.z > 0.0f)) continue;
      for (std::size_t k = 0; k < sky_shapes_.size(); ++k) {
        sky.At(x, y) +=
            glm::vec3(lighting.sky[k].irradiance_rgb) * sky_shapes_[k]->Radiance(direction);
      }
    }
  });
  return sky;
}

const DirectDaylight* FramePipeline::Daylight() const { return effects_->Daylight(); }

std::string FramePipeline::DaylightNote() const {
  return Daylight() != nullptr ? Daylight()->Note() : std::string();
}

const TransportTime& FramePipeline::TransportOf(const Frame& frame, const SunState& sun) {
  const TransportSteps steps{options_.sun_step_s, options_.bounce_step_s};
  const TransportTime wanted = TransportSun(site_, frame, sun, steps);
  if (options_.sun_ahead && transport_ && transport_->time != wanted.time) {
    const std::vector<SampleRegionPolygon> polygons = SampleRegionsOf(frame);
    const bool must_wait = !view_builder_.Stands(frame.camera, polygons);
    if (!must_wait && !view_builder_.IsAtHand(frame.camera, wanted.Place(), polygons)) {
      view_builder_.MakeAhead(wanted.Place());
      return *transport_;
    }
  }
  return transport_.emplace(wanted);
}

void FramePipeline::MakeSunAhead(const Frame& frame) {
  if (!site_ || frame.sun_direction_enu || !(options_.sun_step_s > 0.0)) return;
  const TransportSteps steps{options_.sun_step_s, options_.bounce_step_s};
  // Work that the frame itself waits for comes first.
  if (TransportSun(site_, frame, {}, steps).time != transport_->time) return;
  Frame next;
  next.time = frame.time + std::chrono::nanoseconds(std::llround(options_.sun_step_s * 1e9));
  view_builder_.MakeAhead(TransportSun(site_, next, {}, steps).Place());
}

void FramePipeline::FilterEstimate(FrameResult& result) {
  result.raw_lighting = result.estimate.lighting;
  if (!filter_) return;
  // A source that sees the sky measures it whatever this camera's picture shows.
  const bool sees_sky = !result.estimate.sky_radiance_rgb.empty();
  const FrameFit fit{.misfit = result.estimate.relative_residual,
                     .trusted_misfit = sees_sky ? std::numeric_limits<double>::infinity()
                                                : TrustedResidual(PlaneAlbedoStddev(scene_)),
                     .change = result.estimate.light_change};
  FilteredLighting filtered = filter_->Apply(result.raw_lighting, result.estimate.units, fit);
  const glm::dvec3 raw_sky = result.raw_lighting.SkyIrradianceRgb();
  const glm::dvec3 sky = filtered.lighting.SkyIrradianceRgb();
  for (glm::dvec3& region : result.estimate.sky_radiance_rgb) {
    for (int c = 0; c < 3; ++c) region[c] *= raw_sky[c] > 0.0 ? sky[c] / raw_sky[c] : 1.0;
  }
  result.estimate.lighting = std::move(filtered.lighting);
  result.sun_filter = filtered.sun;
  result.sky_filter = filtered.sky;
}

void FramePipeline::ChooseDrawnLight(FrameLight& light) {
  light.drawn_lighting = unproven_sun_.Without(light.estimate, light.sun_filter.held);
  light.is_drawn_without_sun = light.drawn_lighting.has_value();
  if (!options_.daylight_colours) return;
  auto coloured = WithDaylightColours(light.DrawnLighting());
  if (coloured) light.drawn_lighting = std::move(coloured);
}

}  // namespace pleinair
