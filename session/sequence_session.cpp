#include "session/sequence_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "datasets/picture_frame.h"
#include "scene/elapsed.h"
#include "session/given_lighting.h"
#include "session/session_choices.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {
namespace {

// Directions that a lighting file gives, by frame.
std::map<int, glm::dvec3> GivenSuns(const SessionOptions& options) {
  std::map<int, glm::dvec3> suns;
  if (options.lighting.empty()) return suns;
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sun_direction_enu) suns.emplace(frame, *light.sun_direction_enu);
  }
  return suns;
}

constexpr LatLongSize kSkyImageSize{768, 384};      // A pixel is 0.47 deg, as SkyTable's cells.
constexpr LatLongSize kEnvironmentSize{1024, 512};  // A pixel is 0.35 deg: less than the sun.

glm::vec3 EnvironmentPlace(const LoadedSequence& loaded, bool with_objects) {
  if (with_objects && !loaded.site.objects.empty()) {
    glm::vec3 lower(std::numeric_limits<float>::infinity());
    glm::vec3 upper(-lower);
    for (const VirtualObject& object : loaded.site.objects) {
      const BoundingBox box = BoundingBoxOf(object.mesh);
      lower = glm::min(lower, box.lower_m);
      upper = glm::max(upper, box.upper_m);
    }
    return 0.5f * (lower + upper);
  }
  if (loaded.sequence.environment) return glm::vec3(loaded.sequence.environment->position_m);
  const glm::dmat4 world_from_camera =
      glm::inverse(loaded.sequence.CameraOfFrame(0).camera_from_world);
  return glm::vec3(world_from_camera[3]);
}

std::shared_ptr<const HeadlessContext> MadeCurrent(std::shared_ptr<const HeadlessContext> context) {
  if (!context) context = std::make_shared<const HeadlessContext>();
  context->MakeCurrent();
  return context;
}

// One line; empty where there is none.
std::string FaultOf(const CapturedPicture& captured, const CameraIntrinsics& camera) {
  const glm::ivec2 size =
      std::visit([](const auto& picture) { return glm::ivec2(picture.width, picture.height); },
                 captured.picture);
  if (size != glm::ivec2(camera.width_px, camera.height_px)) {
    return fmt::format("captured picture: expected {}x{} pixels, as its camera has, found {}x{}",
                       camera.width_px,
                       camera.height_px,
                       size.x,
                       size.y);
  }
  if (captured.exposure && !(*captured.exposure > 0.0 && std::isfinite(*captured.exposure))) {
    return fmt::format("captured picture: expected an exposure above 0, found {}",
                       *captured.exposure);
  }
  const auto* radiance = std::get_if<RgbImage>(&captured.picture);
  if (radiance != nullptr && !HasFinitePixel(*radiance, DefectsOf(*radiance))) {
    return "captured picture: expected finite radiances, found none";
  }
  return {};
}

}  // namespace

SequenceSession::SequenceSession(const SessionOptions& options, const Progress& progress)
    : SequenceSession(LoadSequence(options, progress), options) {}

SequenceSession::SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                                 const SessionOptions& options,
                                 std::shared_ptr<const HeadlessContext> context)
    : SequenceSession(std::move(loaded), options, nullptr, std::move(context)) {
  frames_ = FramesOf(options_, *loaded_, notes_);
}

SequenceSession::SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                                 const SessionOptions& options,
                                 std::unique_ptr<FrameSource> frames,
                                 std::shared_ptr<const HeadlessContext> context)
    : loaded_(std::move(loaded)),
      context_(MadeCurrent(std::move(context))),
      options_(options),
      display_(ResponseOf(options, loaded_->sequence)),
      noise_(std::make_shared<SignalNoise>(ResponseOf(options, loaded_->sequence),
                                           options.camera_noise)),
      notes_(loaded_->site.notes),
      given_suns_(GivenSuns(options)),
      compositor_(options.compositor),
      frames_(std::move(frames)) {
  const std::vector<std::string>& of_scene = loaded_->scene.notes;
  notes_.insert(notes_.end(), of_scene.begin(), of_scene.end());
  pipeline_ = std::make_unique<FramePipeline>(
      CompositedScene{loaded_->scene,
                      loaded_->site.model.mesh,
                      loaded_->sequence.site,
                      options.with_objects ? loaded_->site.objects : std::vector<VirtualObject>()},
      MakeSourceFor(options, loaded_->sequence, loaded_->scene.aerosol_optical_depth_500nm),
      compositor_,
      PipelineOptionsFor(options, *loaded_));
}

// What the pipeline and the compositor hold is deleted in the context that it was made in.
SequenceSession::~SequenceSession() {
  try {
    context_->MakeCurrent();
  } catch (const std::exception&) {
    // A context that is lost has nothing left to delete.
  }
}

std::optional<SessionStep> SequenceSession::Next() {
  return Next([](int) { return true; });
}

std::optional<SessionStep> SequenceSession::Next(const std::function<bool(int)>& wanted) {
  if (options_.response) {
    throw std::invalid_argument(
        "SessionOptions::response: the sequence's frames have their own, expected none");
  }
  for (;;) {
    const auto read_start = std::chrono::steady_clock::now();
    auto frame = frames_->Next();
    if (!frame) return std::nullopt;
    if (!wanted(*frame ? (*frame)->index : frame->error().index)) continue;
    if (!*frame) return SessionStep{std::nullopt, tl::unexpected(frame->error())};
    const auto given = given_suns_.find((*frame)->index);
    if (given != given_suns_.end()) (*frame)->sun_direction_enu = given->second;
    const double read_ms = MsSince(read_start);
    SessionStep step = Process(std::move(**frame));
    if (step.result) step.result->timing_ms.read = read_ms;
    return step;
  }
}

SessionStep SequenceSession::Process(Frame frame) {
  context_->MakeCurrent();
  SessionStep step{std::move(frame), {}};
  step.result = pipeline_->Process(*step.frame, PosesAt(step.frame->time));
  return step;
}

SessionStep SequenceSession::Process(CapturedPicture captured) {
  const Sequence& sequence = loaded_->sequence;
  Frame frame;
  frame.index = captured_++;
  frame.time = captured.time;
  frame.camera = captured.camera.value_or(sequence.CameraOfFrame(0));
  frame.sun_direction_enu = sequence.StatedSunDirectionEnu();
  if (const auto given = given_suns_.find(frame.index); given != given_suns_.end()) {
    frame.sun_direction_enu = given->second;
  }
  frame.weather = options_.weather ? options_.weather : sequence.weather;
  if (!options_.ignore_exposure) frame.exposure = captured.exposure;
  frame.fisheye_radiance = std::move(captured.fisheye_radiance);
  if (const std::string fault = FaultOf(captured, frame.camera.intrinsics); !fault.empty()) {
    const FrameError error{frame.index, frame.time, fault};
    return SessionStep{std::nullopt, tl::unexpected(error)};
  }
  if (auto* codes = std::get_if<Rgb8Image>(&captured.picture)) {
    SetCodes(std::move(*codes), display_.Response(), noise_, frame);
    if (!frame.exposure) frame.units = LightUnits::kRelativePerFrame;
  } else {
    SetRadiance(std::move(std::get<RgbImage>(captured.picture)), frame);
  }
  // The sequence's frames were looked at when they were read; these are looked at here.
  const FrameError place{frame.index, frame.time, {}};
  try {
    return Process(std::move(frame));
  } catch (const std::invalid_argument& error) {
    return SessionStep{std::nullopt,
                       tl::unexpected(FrameError{place.index, place.time, error.what()})};
  }
}

GlDescription SequenceSession::Renderer() const {
  context_->MakeCurrent();
  return context_->Describe();
}

Rgb8Image SequenceSession::Show(const SessionStep& step) {
  return display_.Show(step.frame.value(), step.result.value().composite);
}

SequenceSession::Environment SequenceSession::EnvironmentOf(const Lighting& lighting) {
  if (!environment_view_) {
    const PreparedScene& scene = loaded_->scene;
    environment_view_.emplace(scene.patches,
                              scene.survey ? &*scene.survey : nullptr,
                              EnvironmentPlace(*loaded_, options_.with_objects),
                              kEnvironmentSize);
  }
  Environment environment;
  environment.without_sun = pipeline_->EnvironmentRadiance(*environment_view_, lighting);
  environment.with_sun = environment.without_sun;
  environment_view_->AddSun(lighting.sun, environment.with_sun);
  return environment;
}

std::optional<RgbImage> SequenceSession::SkyImageOf(const Lighting& lighting) const {
  const auto is_known = [](const SkyComponent& component) {
    return std::any_of(std::begin(kAllSkyShapeKinds),
                       std::end(kAllSkyShapeKinds),
                       [&](SkyShapeKind kind) { return component.shape == NameOf(kind); });
  };
  if (std::all_of(lighting.sky.begin(), lighting.sky.end(), is_known)) return std::nullopt;
  return pipeline_->SkyRadiance(lighting, kSkyImageSize);
}

std::vector<glm::dmat4> SequenceSession::PosesAt(UtcTime time) const {
  if (!options_.with_objects) return {};
  return ObjectPosesAt(loaded_->site, SecondsSinceFirstFrame(loaded_->sequence, time));
}

}  // namespace pleinair
