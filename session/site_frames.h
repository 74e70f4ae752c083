// Frames of a camera, a video or pictures at a site, with the poses that markers in them or a
// tracker give.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "datasets/camera/camera_capture.h"
#include "datasets/camera/live_frame_source.h"
#include "datasets/camera/pose_stream.h"
#include "datasets/event.h"
#include "datasets/frame_source.h"
#include "datasets/picture_source.h"
#include "session/loaded_sequence.h"
#include "session/session_options.h"

namespace pleinair {

// The file that --poses names, readable before the first frame: also for standard input.
std::filesystem::path PoseFileOf(const std::filesystem::path& poses);

// The frames of a video, a picture or a folder of pictures. Throws as MakeFrameSourceAt.
std::unique_ptr<FrameSource> PosedFramesAt(const LoadedSequence& loaded,
                                           const std::string& input,
                                           const PictureTimes& times,
                                           const SessionOptions& options,
                                           const PoseNote& note);

// A camera that streams, and where it is. One thread, but for Stop.
class PosedCamera {
 public:
  // `options`: markers and poses. Throws as PoseStream. Keeps both references.
  PosedCamera(const SessionOptions& options, CameraCapture& capture, EventLog& events);

  // Markers or a tracker say where it is.
  bool Moves() const { return moves_; }
  // For LoadSite: a tracker's poses are no file that is read before.
  static SessionOptions OfflineOptions(SessionOptions options);
  SessionOptions OptionsOfSession(SessionOptions options) const;

  struct Taps {
    // Each may be empty.
    CameraFrameTap taken;                     // With every picture, as it comes.
    std::function<void(CameraFrame)> record;  // With its pose, where the camera moves.
  };
  // The camera's frames at the site. One source at a time: it refers to this object.
  std::unique_ptr<FrameSource> FramesAt(const LoadedSequence& loaded,
                                        const SessionOptions& options,
                                        const Taps& taps);
  // From any thread: no frame waits for its pose from now on.
  void Stop();

 private:
  CameraCapture& capture_;
  EventLog& events_;
  bool moves_ = false;
  std::optional<PoseStream> poses_;
  CameraFrame last_picture_;  // A moving camera's: recorded once its pose is known.
};

}  // namespace pleinair
