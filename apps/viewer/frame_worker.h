// Frames for the window, made on a thread of their own: the window never waits for them.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/viewer/view_command.h"
#include "apps/viewer/viewed_frame.h"
#include "datasets/event.h"
#include "scene/ray_caster.h"

namespace pleinair {

// What is viewed, once it is read and prepared.
struct ViewedSite {
  std::shared_ptr<const LoadedSequence> loaded;
  RayCaster caster;           // Casts rays at the site's mesh.
  std::optional<int> frames;  // None: a camera's, without end.
  bool is_live = false;
  bool can_seek = false;
  bool camera_moves = false;  // Markers or a tracker say where it is.
  std::string renderer;
};

// What has come since it was last asked.
struct WorkerNews {
  std::shared_ptr<const ViewedSite> site;    // Null: not ready yet, or as before.
  std::shared_ptr<const ViewedFrame> frame;  // The last one; null: none is new.
  std::vector<LightPoint> lights;            // The light of all frames.
  std::vector<Event> events;
  std::vector<std::string> notes;  // What was assumed, repaired or refused.
  std::string stage;               // Name of long work that goes on; empty: none.
  double stage_share = 0.0;
  bool has_ended = false;            // The frames.
  std::optional<bool> is_recording;  // Where that has changed.
  std::string failure;               // Why there will be nothing more, one line; empty: it goes on.
};

class FrameWorker {
 public:
  // `wake` is called from its thread where there is news.
  FrameWorker(const ViewCommandOptions& options, std::function<void()> wake);
  // Ends what can be ended, and waits for the rest: a stage of preparation.
  ~FrameWorker();
  FrameWorker(const FrameWorker&) = delete;
  FrameWorker& operator=(const FrameWorker&) = delete;

  void Post(const ViewRequest& request);
  WorkerNews Take();

 private:
  class Viewing;
  void Run();
  bool IsEnding();
  void Report(const std::function<void(WorkerNews&)>& change);

  ViewCommandOptions options_;
  std::function<void()> wake_;
  std::mutex mutex_;  // For the members that follow.
  std::condition_variable changed_;
  std::optional<ViewRequest> request_;
  bool is_ending_ = false;
  WorkerNews news_;
  std::function<void()> interrupt_;  // Ends a wait for a camera's picture.
  std::thread thread_;
};

}  // namespace pleinair
