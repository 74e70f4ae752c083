// From a sequence's folder to composites, frame by frame, for its own frames or a caller's. Writes
// nothing except the cache.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "datasets/frame_source.h"
#include "pipeline/frame_pipeline.h"
#include "relight/progress.h"
#include "render/gl_context.h"
#include "session/loaded_sequence.h"
#include "session/picture_display.h"
#include "session/session_options.h"

namespace pleinair {

// One frame of a session, and its result.
struct SessionStep {
  std::optional<Frame> frame;  // None where it could not be read.
  tl::expected<FrameResult, FrameError> result;
};

// A picture of the caller's, from the sequence's camera or another one at its place.
struct CapturedPicture {
  // Scene-linear radiance, or the camera's code values, which SessionOptions::response and the
  // exposure convert to light.
  std::variant<RgbImage, Rgb8Image> picture;
  UtcTime time{};
  std::optional<Camera> camera;      // None: that of the sequence's first frame.
  std::optional<double> exposure;    // For codes: factor from radiance to [0, 1]. None: unknown.
  std::optional<double> exposure_s;  // How long the shutter was open. None: unknown.
  // The sky camera's picture, where the session's source is the fish-eye: as in Frame.
  std::optional<RgbImage> fisheye_radiance;
};

// Draws in an OpenGL context of its own unless it is given one. It makes the context current, and
// the context stays current. To be used on the thread that made it, or the given context.
class SequenceSession {
 public:
  // Reads and prepares first. Throws as LoadSequence, and as HeadlessContext where it makes one.
  explicit SequenceSession(const SessionOptions& options, const Progress& progress = {});

  // In `options` the offline part, frames, markers, exposure, weather and camera noise must equal
  // those of `loaded`.
  SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                  const SessionOptions& options,
                  std::shared_ptr<const HeadlessContext> context = nullptr);
  // Next uses `frames` in place of the sequence's own.
  SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                  const SessionOptions& options,
                  std::unique_ptr<FrameSource> frames,
                  std::shared_ptr<const HeadlessContext> context = nullptr);
  ~SequenceSession();
  SequenceSession(const SequenceSession&) = delete;
  SequenceSession& operator=(const SequenceSession&) = delete;

  // Processes the sequence's next frame; none at the end. Frames for which `wanted` is false are
  // skipped.
  std::optional<SessionStep> Next();
  std::optional<SessionStep> Next(const std::function<bool(int)>& wanted);

  // Next continues with frame `index`, 0-based. False where frames come only in order: a camera's.
  bool Seek(int index) { return frames_->Seek(index); }

  // Processes a frame that is not the sequence's, or one of its frames again, at the same place.
  SessionStep Process(Frame frame);
  // Such pictures are counted from 0 on. One of another size than its camera's is that step's
  // error. A diffuse mask over the sequence's first frame is not used for them.
  SessionStep Process(CapturedPicture captured);

  // Replaces the virtual objects from the next frame on. Files are relative to the sequence's
  // folder, or absolute; those of present objects are not read again. The light stays. Throws as
  // LoadObject; then nothing changes.
  void SetObjects(std::span<const VirtualObjectEntry> objects);

  // Draws the last step, which must have succeeded, again in its light: after SetObjects or
  // SetEffects.
  SessionStep Redraw(const SessionStep& last);

  // As FramePipeline::SetEffects.
  void SetEffects(const EffectSettings& effects) { pipeline_->SetEffects(effects); }

  // As FramePipeline.
  const SurfaceView& WholeView() { return pipeline_->WholeView(); }
  std::span<const DiffuseSample> Samples() const { return pipeline_->Samples(); }

  // The composite of a step that succeeded, as the camera would have shown it, or brighter by
  // `stops`.
  Rgb8Image Show(const SessionStep& step, double stops = 0.0);
  const PictureDisplay& Display() const { return display_; }
  const LoadedSequence& Loaded() const { return *loaded_; }
  GlDescription Renderer() const;

  // Notes since the last call on what was assumed, repaired or left out, marker poses included.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }
  // Radiance of the real light at the objects' place; without objects at the survey map's place, or
  // at the first frame's camera. Scene-linear, lat-long, after a frame that succeeded, with its
  // lighting. The second one includes the sun's disc.
  struct Environment {
    RgbImage without_sun;
    RgbImage with_sun;
  };
  Environment EnvironmentOf(const Lighting& lighting);
  // That place, in the world.
  glm::dvec3 EnvironmentPlaceM() const;
  // As FramePipeline.
  const IrradianceVolume& Volume() const { return pipeline_->Volume(); }
  // Radiance of the sky in the last frame that succeeded, lat-long. Only where the names of its
  // shapes do not describe its sky: a sky from a fish-eye camera, or given as a picture.
  std::optional<RgbImage> SkyImageOf(const Lighting& lighting) const;
  // See FramePipeline.
  const DirectDaylight* Daylight() const { return pipeline_->Daylight(); }
  std::string DaylightNote() const { return pipeline_->DaylightNote(); }

 private:
  std::vector<glm::dmat4> PosesAt(UtcTime time) const;
  // Adds entry `entry` of the objects again, as entry `index`.
  SiteObjects CopyOf(std::size_t entry, std::size_t index) const;

  std::shared_ptr<const LoadedSequence> loaded_;
  std::shared_ptr<const HeadlessContext> context_;
  SessionOptions options_;
  PictureDisplay display_;
  std::shared_ptr<const SignalNoise> noise_;  // For captured code values.
  int captured_ = 0;
  std::vector<std::string> notes_;
  std::map<int, glm::dvec3> given_suns_;             // Sun directions of a lighting file, by frame.
  std::optional<EnvironmentView> environment_view_;  // Created at the first use.
  Compositor compositor_;
  std::unique_ptr<FramePipeline> pipeline_;
  // The virtual objects: entries as loaded, their present poses, and the parts.
  std::vector<VirtualObjectEntry> entries_;
  std::vector<glm::dmat4> world_from_loaded_;
  SiteObjects objects_;
  std::unique_ptr<FrameSource> frames_;
};

}  // namespace pleinair
