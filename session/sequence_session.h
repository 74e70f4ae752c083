// From a sequence's folder to composites, frame by frame: of its own frames, or of a caller's.
// Nothing is written but the cache.
#pragma once

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

struct SessionStep {
  std::optional<Frame> frame;  // None where it could not be read.
  tl::expected<FrameResult, FrameError> result;
};

// A picture of the caller's own, from the sequence's camera or another one at its place.
struct CapturedPicture {
  // Scene-linear radiance, or the camera's code values, which SessionOptions::response and the
  // exposure make light of.
  std::variant<RgbImage, Rgb8Image> picture;
  UtcTime time{};
  std::optional<Camera> camera;      // None: that of the sequence's first frame.
  std::optional<double> exposure;    // Of codes: radiance to [0, 1]. None: unknown.
  std::optional<double> exposure_s;  // How long the shutter was open. None: unknown.
  // The sky camera's, where the session's source is the fish-eye: as Frame has it.
  std::optional<RgbImage> fisheye_radiance;
};

// Draws in an OpenGL context of its own unless it is given one, and makes that current itself; it
// stays current. Used on the thread that made it, or the context.
class SequenceSession {
 public:
  // Reads and prepares first. Throws as LoadSequence, and as HeadlessContext where it makes one.
  explicit SequenceSession(const SessionOptions& options, const Progress& progress = {});

  // What `options` says of the offline part, frames, markers, exposure, weather and camera noise
  // has to be as it was when `loaded` was made.
  SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                  const SessionOptions& options,
                  std::shared_ptr<const HeadlessContext> context = nullptr);
  // Next gives frames of `frames`, in place of the sequence's own.
  SequenceSession(std::shared_ptr<const LoadedSequence> loaded,
                  const SessionOptions& options,
                  std::unique_ptr<FrameSource> frames,
                  std::shared_ptr<const HeadlessContext> context = nullptr);
  ~SequenceSession();
  SequenceSession(const SequenceSession&) = delete;
  SequenceSession& operator=(const SequenceSession&) = delete;

  // The sequence's next frame; none at the end. Frames for which `wanted` is false are passed over.
  std::optional<SessionStep> Next();
  std::optional<SessionStep> Next(const std::function<bool(int)>& wanted);

  // The next frame that Next gives is frame `index`, 0-based. False where frames come in order
  // alone: a camera's.
  bool Seek(int index) { return frames_->Seek(index); }

  // Of a frame that is not the sequence's, or is so again, at the same place.
  SessionStep Process(Frame frame);
  // Such pictures are counted from 0 on. One that does not fit its camera is that step's error. A
  // diffuse mask over the sequence's first frame does not hold for them.
  SessionStep Process(CapturedPicture captured);

  // What is put into the picture from the next frame on, in place of the sequence's objects. Files
  // are relative to the sequence's folder, or absolute; those that are in the picture already are
  // not read again. The light stays. Throws as LoadObject; then all stay what they were.
  void SetObjects(std::span<const VirtualObjectEntry> objects);

  // The last step, which has to have succeeded, drawn again in its light: after SetObjects or
  // SetEffects.
  SessionStep Redraw(const SessionStep& last);

  // As FramePipeline::SetEffects.
  void SetEffects(const EffectSettings& effects) { pipeline_->SetEffects(effects); }

  // As FramePipeline.
  const SurfaceView& View() const { return pipeline_->View(); }
  std::span<const DiffuseSample> Samples() const { return pipeline_->Samples(); }

  // The composite of a step that succeeded, as the camera would have shown it.
  Rgb8Image Show(const SessionStep& step);
  const PictureDisplay& Display() const { return display_; }
  const LoadedSequence& Loaded() const { return *loaded_; }
  GlDescription Renderer() const;

  // What was assumed, repaired or left out since the last call, marker poses included.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }
  // The real light where the objects are, or without any where the survey's map was taken, or the
  // first frame's camera. Lat-long, after a frame that succeeded, with its lighting; the second one
  // has the sun's disc in it.
  struct Environment {
    RgbImage without_sun;
    RgbImage with_sun;
  };
  Environment EnvironmentOf(const Lighting& lighting);
  // Where that is, in the world.
  glm::dvec3 EnvironmentPlaceM() const;
  // As FramePipeline.
  const IrradianceVolume& Volume() const { return pipeline_->Volume(); }
  // Lat-long, of the last frame that succeeded, where the names of its shapes do not describe its
  // sky: a sky seen by a fish-eye camera, or given as a picture.
  std::optional<RgbImage> SkyImageOf(const Lighting& lighting) const;
  // See FramePipeline.
  const DirectDaylight* Daylight() const { return pipeline_->Daylight(); }
  std::string DaylightNote() const { return pipeline_->DaylightNote(); }

 private:
  std::vector<glm::dmat4> PosesAt(UtcTime time) const;
  // Entry `entry` of the objects once more, as entry `index`.
  SiteObjects CopyOf(std::size_t entry, std::size_t index) const;

  std::shared_ptr<const LoadedSequence> loaded_;
  std::shared_ptr<const HeadlessContext> context_;
  SessionOptions options_;
  PictureDisplay display_;
  std::shared_ptr<const SignalNoise> noise_;  // Of captured code values.
  int captured_ = 0;
  std::vector<std::string> notes_;
  std::map<int, glm::dvec3> given_suns_;  // Directions that a lighting file gives, by frame.
  std::optional<EnvironmentView> environment_view_;  // Made when first asked for.
  Compositor compositor_;
  std::unique_ptr<FramePipeline> pipeline_;
  // What is put into the picture: entries as they were loaded, where each has been taken since, and
  // the parts.
  std::vector<VirtualObjectEntry> entries_;
  std::vector<glm::dmat4> world_from_loaded_;
  SiteObjects objects_;
  std::unique_ptr<FrameSource> frames_;
};

}  // namespace pleinair
