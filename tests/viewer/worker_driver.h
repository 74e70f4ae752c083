// A FrameWorker as the window drives it, without the window.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/viewer/frame_worker.h"

namespace pleinair {

class WorkerDriver {
 public:
  explicit WorkerDriver(const ViewCommandOptions& options)
      : worker_(options, [this] {
          const std::lock_guard lock(mutex_);
          has_news_ = true;
          changed_.notify_all();
        }) {
    request.effects = options.pipeline.effects;
  }

  // Posts the request and takes news until `holds`; false after a time that only a fault needs.
  bool Reach(const std::function<bool()>& holds) {
    if (site) worker_.Post(request);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (!holds()) {
      {
        std::unique_lock lock(mutex_);
        if (!changed_.wait_until(lock, end, [this] { return has_news_; })) return false;
        has_news_ = false;
      }
      Take();
    }
    return true;
  }

  // The first frame, with the site's own objects, complete.
  ::testing::AssertionResult Open() {
    if (!Reach([this] {
          return (frame && (!frame->Succeeded() || frame->IsComplete())) || !failure.empty();
        }) ||
        !frame) {
      return ::testing::AssertionFailure() << "no frame: " << failure;
    }
    if (!frame->Succeeded()) {
      return ::testing::AssertionFailure() << frame->step.result.error().reason;
    }
    return ::testing::AssertionSuccess();
  }

  bool ReachFrame(const std::function<bool(const ViewedFrame&)>& holds) {
    return Reach([&] { return frame && holds(*frame); });
  }

  ViewRequest request;
  std::shared_ptr<const ViewedSite> site;
  std::shared_ptr<const ViewedFrame> frame;
  int sites = 0;
  std::vector<LightPoint> lights;
  std::vector<std::string> notes;
  std::vector<std::string> stages;
  // Indices of the frames that were taken, in order; but of those that took a coarse one's place.
  std::vector<int> shown;
  std::string failure;
  bool has_ended = false;

 private:
  static bool IsCoarse(const ViewedFrame& of) {
    return of.Succeeded() && of.step.result->is_light_coarse;
  }

  void Take() {
    WorkerNews news = worker_.Take();
    if (news.site) {
      if (!site) {
        request.objects = news.site->loaded->sequence.virtual_objects;
        ++request.edits;
        worker_.Post(request);
      }
      site = news.site;
      ++sites;
    }
    if (news.frame) {
      const bool is_finer = frame && IsCoarse(*frame) && frame->Index() == news.frame->Index();
      frame = news.frame;
      if (!is_finer) shown.push_back(frame->Index());
    }
    lights.insert(lights.end(), news.lights.begin(), news.lights.end());
    notes.insert(notes.end(), news.notes.begin(), news.notes.end());
    if (!news.stage.empty()) stages.push_back(news.stage);
    failure = news.failure;
    has_ended = news.has_ended;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool has_news_ = false;
  FrameWorker worker_;  // It ends before what its thread uses.
};

}  // namespace pleinair
