// One open handle of the device, and the timeline that fills its buffers.
//
// Nothing runs in the background: whatever is due at a point in time happens when the program next
// asks, exactly as if it had happened then. The handle's descriptor is a timer that is readable
// whenever a kernel's poll() would report the device, so real poll(), select() and epoll work.
#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "apps/camera_stand_in/device_state.h"
#include "apps/camera_stand_in/shim/renderer.h"

namespace pleinair::stand_in {

std::int64_t MonotonicNs();

// What poll() reports of a handle.
enum class Readiness { kNothing, kBuffer, kError, kGone };

struct Buffer {
  bool is_queued = false;
  bool is_done = false;
};

// A buffer that a picture was captured for; the picture is rendered when the buffer is dequeued.
struct Capture {
  std::uint32_t buffer = 0;
  Shot shot;
  std::uint32_t sequence = 0;
  std::int64_t time_ns = 0;
  bool is_last = false;
  bool is_short = false;
  bool has_error = false;
  bool is_damaged = false;
};

class Handle {
 public:
  // `timer_fd` is what the program holds; the counter of events and the pictures are taken over.
  Handle(DeviceState& state, int timer_fd, int event_fd, int pictures_fd);
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle();

  int EventFd() const { return event_fd_; }
  bool IsGone() const { return plug_count_ != state_.plug_count; }
  bool IsStreaming() const { return is_streaming_; }
  bool HasBuffers() const { return !buffers_.empty(); }

  // Lets everything happen that is due by now.
  void Advance();
  Readiness Ready() const;

  // Each returns 0 or an errno. All but Dequeue are called after Advance.
  int Allocate(std::uint32_t& count);
  int Describe(v4l2_buffer& buffer) const;
  int Queue(v4l2_buffer& buffer);
  int Start();
  int Stop();
  // EAGAIN: none is filled yet. Fills `capture`, and reports it in `buffer`.
  int Dequeue(v4l2_buffer& buffer, Capture& capture);
  // The part of Dequeue that needs no lock. Returns the picture's bytes; where there are none,
  // `flags` says so.
  std::uint32_t Render(const Capture& capture, std::uint32_t& flags);
  // The memory behind an offset that Describe gave; -1 where there is none.
  int BuffersFd() const { return buffers_fd_; }
  // Whether no other handle, of any process, has buffers.
  bool OwnsDevice();

  bool wants_source_changes = false;
  void ReportSourceChange();
  bool HasEvent() const { return !events_.empty(); }
  int NextEvent(v4l2_event& event);

 private:
  struct Next {
    enum class Kind { kNothing, kPicture, kUnplug, kSourceChange } kind = Kind::kNothing;
    Fault* fault = nullptr;  // What happens to the picture.
  };
  std::int64_t TickNs(std::int64_t tick) const;
  void Skip(int ticks);
  void Plan();
  bool Do();
  bool DoPicture();
  void Fail();
  void Unplug(bool renumber);
  void ChangeSize();
  void Arm();
  void Release();

  DeviceState& state_;
  const int timer_fd_;  // A duplicate: the program may have closed its own.
  const int event_fd_;
  const int pictures_fd_;
  const std::uint32_t plug_count_;
  std::mutex rendering_;  // Held while the buffers' memory is written or replaced.
  Renderer renderer_;

  int owner_fd_ = -1;  // Locked while it has buffers.
  int buffers_fd_ = -1;
  std::span<std::uint8_t> memory_;
  std::size_t stride_ = 0;
  Format format_;  // The buffers' format.
  std::vector<Buffer> buffers_;
  std::deque<std::uint32_t> queued_;
  std::deque<Capture> done_;

  bool is_streaming_ = false;
  bool has_failed_ = false;
  bool has_ended_ = false;    // The last picture has been captured.
  std::int64_t base_ns_ = 0;  // Time of tick 0; a stall moves it.
  std::int64_t tick_ = 0;
  std::int64_t last_time_ns_ = 0;
  Next next_;
  Fault* unseen_ = nullptr;  // A fault whose picture found no buffer: the next one has it.
  std::deque<v4l2_event> events_;
  std::uint32_t event_sequence_ = 0;
};

}  // namespace pleinair::stand_in
