#include "session/sequence_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "calib/timed_pose.h"
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

// Exactly affine: a product's last row has rounding errors.
glm::dmat4 MadeAffine(glm::dmat4 matrix) {
  for (int column = 0; column < 4; ++column) matrix[column].w = column == 3 ? 1.0 : 0.0;
  return matrix;
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
  if (captured.camera) {
    if (const std::string fault = FaultOfPose(captured.camera->camera_from_world); !fault.empty()) {
      return "captured picture: camera_from_world: expected " + fault;
    }
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
  if (!options_.lighting.empty()) RequireLightingOf(loaded_->sequence, options_.lighting);
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
  if (options.with_objects) {
    entries_ = loaded_->sequence.virtual_objects;
    world_from_loaded_.assign(entries_.size(), glm::dmat4(1.0));
    objects_ = {loaded_->site.objects, loaded_->site.motions, {}};
  }
  const std::vector<std::string>& of_scene = loaded_->scene.notes;
  notes_.insert(notes_.end(), of_scene.begin(), of_scene.end());
  pipeline_ = std::make_unique<FramePipeline>(
      CompositedScene{
          loaded_->scene, loaded_->site.model.mesh, loaded_->sequence.site, objects_.parts},
      MakeSourceFor(options, loaded_->sequence, loaded_->scene.aerosol_optical_depth_500nm),
      compositor_,
      PipelineOptionsFor(options, *loaded_));
}

// OpenGL objects of the pipeline and the compositor are deleted in the context that they were made
// in.
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

SessionStep SequenceSession::Redraw(const SessionStep& last) {
  context_->MakeCurrent();
  const Frame& frame = last.frame.value();
  return {frame, pipeline_->Redraw(frame, last.result.value(), PosesAt(frame.time))};
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
  frame.exposure_s = captured.exposure_s;
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
  // The sequence's frames were checked when they were read; these are checked here.
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

Rgb8Image SequenceSession::Show(const SessionStep& step, double stops) {
  return display_.Show(step.frame.value(), step.result.value().composite, stops);
}

SequenceSession::Environment SequenceSession::EnvironmentOf(const Lighting& lighting) {
  if (!environment_view_) {
    const PreparedScene& scene = loaded_->scene;
    environment_view_.emplace(scene.patches,
                              scene.survey ? &*scene.survey : nullptr,
                              glm::vec3(EnvironmentPlaceM()),
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

void SequenceSession::SetObjects(std::span<const VirtualObjectEntry> objects) {
  const auto has_mesh_of = [](const VirtualObjectEntry& a, const VirtualObjectEntry& b) {
    return a.mesh == b.mesh;
  };
  std::vector<VirtualObjectEntry> entries = entries_;
  if (!std::equal(objects.begin(), objects.end(), entries_.begin(), entries_.end(), has_mesh_of)) {
    SiteObjects others;
    entries.clear();
    for (const VirtualObjectEntry& wanted : objects) {
      const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const auto& entry) {
        return entry.mesh == wanted.mesh;
      });
      others.Append(
          known == entries_.end()
              ? LoadObject(loaded_->sequence.folder, wanted, entries.size())
              : CopyOf(static_cast<std::size_t>(known - entries_.begin()), entries.size()));
      entries.push_back(known == entries_.end() ? wanted : *known);
    }
    context_->MakeCurrent();
    pipeline_->SetObjects(others.parts, loaded_->site.model.mesh);
    objects_ = std::move(others);
    entries_ = std::move(entries);
    notes_.insert(notes_.end(), objects_.notes.begin(), objects_.notes.end());
  }
  environment_view_.reset();
  world_from_loaded_.clear();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const glm::dmat4& loaded = entries_[i].world_from_object;
    const glm::dmat4& wanted = objects[i].world_from_object;
    world_from_loaded_.push_back(wanted == loaded ? glm::dmat4(1.0)
                                                  : MadeAffine(wanted * glm::inverse(loaded)));
  }
}

SiteObjects SequenceSession::CopyOf(std::size_t entry, std::size_t index) const {
  SiteObjects copy;
  for (std::size_t i = 0; i < objects_.parts.size(); ++i) {
    if (objects_.motions[i].entry != entry) continue;
    copy.parts.push_back(objects_.parts[i]);
    copy.motions.push_back(objects_.motions[i]);
    copy.motions.back().entry = index;
  }
  return copy;
}

std::vector<glm::dmat4> SequenceSession::PosesAt(UtcTime time) const {
  std::vector<glm::dmat4> poses =
      ObjectPosesAt(objects_.motions, SecondsSinceFirstFrame(loaded_->sequence, time));
  const bool is_any_elsewhere =
      std::any_of(world_from_loaded_.begin(), world_from_loaded_.end(), [](const auto& moved) {
        return moved != glm::dmat4(1.0);
      });
  if (!is_any_elsewhere) return poses;
  poses.resize(objects_.parts.size(), glm::dmat4(1.0));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = MadeAffine(world_from_loaded_[objects_.motions[i].entry] * poses[i]);
  }
  return poses;
}

glm::dvec3 SequenceSession::EnvironmentPlaceM() const {
  if (!objects_.parts.empty()) {
    glm::dvec3 lower_m(std::numeric_limits<double>::infinity());
    glm::dvec3 upper_m(-lower_m);
    for (std::size_t i = 0; i < objects_.parts.size(); ++i) {
      const glm::dmat4& moved = world_from_loaded_[objects_.motions[i].entry];
      for (const glm::vec3& corner_m : CornersOf(BoundingBoxOf(objects_.parts[i].mesh))) {
        const glm::dvec3 place_m(moved * glm::dvec4(corner_m, 1.0));
        lower_m = glm::min(lower_m, place_m);
        upper_m = glm::max(upper_m, place_m);
      }
    }
    return 0.5 * (lower_m + upper_m);
  }
  const Sequence& sequence = loaded_->sequence;
  if (sequence.environment) return sequence.environment->position_m;
  return sequence.CameraOfFrame(0).CentreWorldM();
}

}  // namespace pleinair
