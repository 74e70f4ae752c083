// Where the window's frames come from: a sequence, files at a site, or a camera.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/view_command.h"
#include "calib/pose_track.h"
#include "datasets/camera/camera_capture.h"
#include "datasets/event.h"
#include "datasets/recording/recorder.h"
#include "session/sequence_session.h"
#include "session/site_frames.h"

namespace pleinair {

// One thread, but for Stop.
class ViewSource {
 public:
  // Opens a camera; keeps both. Throws as CameraCapture, and where the site's camera has another
  // shape.
  ViewSource(const ViewCommandOptions& options, EventLog& events);
  // Ends a recording.
  ~ViewSource();
  ViewSource(const ViewSource&) = delete;
  ViewSource& operator=(const ViewSource&) = delete;

  bool IsLive() const { return capture_.has_value(); }
  // Markers or a tracker say where the camera is.
  bool CameraMoves() const { return !options_.markers.empty() || !options_.poses.empty(); }
  double FramesPerSecond() const;  // A camera's; 0: not known.
  UtcTime Now() const;
  // A wait for a camera's picture ends, and so does its stream.
  void Stop();

  // Poses from outside are read the first time: a pipe gives them once. Throws as LoadSequence and
  // LoadSite; std::invalid_argument where `options` asks for what the input has not.
  std::shared_ptr<const LoadedSequence> Load(const SessionOptions& options,
                                             const Progress& progress);
  // For a session of what was loaded. In place of the sequence's own frames; null: those. A
  // camera's go on from session to session.
  std::unique_ptr<FrameSource> Frames(const LoadedSequence& loaded, const SessionOptions& options);
  // What a session of these frames is asked for.
  SessionOptions OptionsOfSession(const SessionOptions& options) const;

  // Records a camera into a new folder. Throws as Recorder.
  void Record(bool is_recording);
  bool IsRecording() const { return recorder_.has_value(); }
  // Why a recording goes on no longer, one line; empty: it does.
  std::string WhyRecordingStopped() const;
  // Takes a camera's next picture, for the recorder alone. False at the end of the stream.
  bool PassOver() { return live_frames_->Next().has_value(); }
  // To the recording, where there is one.
  void AddEvents(const std::vector<Event>& events);

 private:
  const ViewCommandOptions& options_;
  EventLog& events_;
  std::optional<PoseTrack> poses_;  // Poses for recorded frames.
  std::optional<Sequence> site_;
  std::optional<CameraCapture> capture_;
  std::optional<PosedCamera> camera_;
  std::shared_ptr<FrameSource> live_frames_;  // The last that were made.
  std::optional<Recorder> recorder_;
};

}  // namespace pleinair
