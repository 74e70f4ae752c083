#include "datasets/camera/pose_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <utility>

#include "calib/json_cursor.h"
#include "datasets/pose_lines.h"

namespace pleinair {
namespace {

constexpr std::size_t kMostPoses = 4096;  // Four seconds of the fastest trackers.
constexpr std::size_t kMostLineBytes = 1 << 16;
// Interval of reading a slot, or a file's end. A tracker of 500 poses a second loses none.
constexpr std::chrono::milliseconds kLook{1};
constexpr int kTickMs = 50;  // Interval of checks for a stop.
constexpr std::string_view kSharedMemory = "shm:";

[[noreturn]] void RefuseSource(const std::string& source, const std::string& expected) {
  throw std::runtime_error(source + ": expected " + expected);
}

}  // namespace

void PoseStreamOptions::Validate() const {
  track.Validate();
  if (wait_s >= 0.0 && std::isfinite(wait_s)) return;
  throw std::invalid_argument("wait_s: expected 0 or more seconds, found " +
                              std::to_string(wait_s));
}

class PoseStream::Input {
 public:
  using Sink = std::function<void(const tl::expected<TimedPose, std::string>&)>;

  virtual ~Input() = default;
  // Passes poses, or why one is invalid, to `sink` until the source ends or `stop` is requested.
  virtual void Read(const std::stop_token& stop, const Sink& sink) = 0;
};

class PoseStream::LineInput final : public Input {
 public:
  explicit LineInput(const std::string& source) : source_(source) {
    if (source == "-") {
      descriptor_ = dup(STDIN_FILENO);
    } else {
      // With a writer of its own a pipe does not end when the tracker does.
      struct stat status {};
      const bool is_pipe = stat(source.c_str(), &status) == 0 && S_ISFIFO(status.st_mode);
      follows_ = true;
      descriptor_ = open(source.c_str(), (is_pipe ? O_RDWR : O_RDONLY) | O_NONBLOCK | O_CLOEXEC);
    }
    if (descriptor_ < 0) {
      RefuseSource(source, std::string("a pipe or file of camera poses: ") + std::strerror(errno));
    }
  }
  ~LineInput() override { close(descriptor_); }
  LineInput(const LineInput&) = delete;
  LineInput& operator=(const LineInput&) = delete;

  void Read(const std::stop_token& stop, const Sink& sink) override {
    char bytes[4096];
    while (!stop.stop_requested()) {
      pollfd ready{descriptor_, POLLIN, 0};
      if (poll(&ready, 1, kTickMs) <= 0) continue;
      const ssize_t count = read(descriptor_, bytes, sizeof bytes);
      if (count > 0) {
        Split(std::string_view(bytes, static_cast<std::size_t>(count)), sink);
      } else if (count == 0 && !follows_) {
        return;
      } else if (count == 0 || errno == EAGAIN) {
        std::this_thread::sleep_for(kLook);
      } else if (errno != EINTR) {
        sink(tl::unexpected(source_ + ": " + std::strerror(errno)));
        return;
      }
    }
  }

 private:
  void Split(std::string_view bytes, const Sink& sink) {
    for (const char byte : bytes) {
      if (byte != '\n') {
        if (line_.size() < kMostLineBytes) line_ += byte;
        continue;
      }
      const std::string label = source_ + ":" + std::to_string(++number_);
      if (line_.size() == kMostLineBytes) {
        sink(tl::unexpected(label + ": expected a camera pose, found a line of 64 KiB or more"));
      } else if (line_.find_first_not_of(" \t\r") != std::string::npos) {
        try {
          sink(ReadPoseLine(line_, label));
        } catch (const JsonError& error) {
          sink(tl::unexpected(std::string(error.what())));
        }
      }
      line_.clear();
    }
  }

  std::string source_;
  int descriptor_ = -1;
  bool follows_ = false;  // More may come after the end.
  std::string line_;
  std::int64_t number_ = 0;
};

class PoseStream::SlotInput final : public Input {
 public:
  explicit SlotInput(const std::string& source) : source_(source) {
    const std::string name = "/" + source.substr(kSharedMemory.size());
    const int descriptor = shm_open(name.c_str(), O_RDONLY | O_CLOEXEC, 0);
    if (descriptor < 0) {
      RefuseSource(source,
                   std::string("shared memory that a tracker has made: ") + std::strerror(errno));
    }
    struct stat status {};
    const bool is_large =
        fstat(descriptor, &status) == 0 && status.st_size >= static_cast<off_t>(sizeof(PoseSlot));
    void* mapped = is_large ? mmap(nullptr, sizeof(PoseSlot), PROT_READ, MAP_SHARED, descriptor, 0)
                            : MAP_FAILED;
    close(descriptor);
    if (mapped == MAP_FAILED) RefuseSource(source, "shared memory of 160 bytes or more");
    words_ = static_cast<std::uint64_t*>(mapped);
    PoseSlot slot{};
    std::memcpy(&slot, words_, offsetof(PoseSlot, count));
    if (std::string_view(slot.magic, sizeof slot.magic) != "plnrpose" || slot.version != 1) {
      Unmap();
      RefuseSource(source, "a slot that begins with plnrpose and version 1");
    }
  }
  ~SlotInput() override { Unmap(); }
  SlotInput(const SlotInput&) = delete;
  SlotInput& operator=(const SlotInput&) = delete;

  void Read(const std::stop_token& stop, const Sink& sink) override {
    std::uint64_t last = 0;
    while (!stop.stop_requested()) {
      const std::optional<PoseSlot> slot = Copy();
      if (!slot || slot->count == last) {
        std::this_thread::sleep_for(kLook);
        continue;
      }
      last = slot->count;
      TimedPose pose{UtcTime(std::chrono::nanoseconds(slot->time_utc_ns)), {}};
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
          pose.camera_from_world[column][row] = slot->camera_from_world[4 * row + column];
        }
      }
      sink(pose);
    }
  }

 private:
  using Words = std::array<std::uint64_t, sizeof(PoseSlot) / sizeof(std::uint64_t)>;
  static constexpr std::size_t kCountWord = offsetof(PoseSlot, count) / sizeof(std::uint64_t);

  void Unmap() {
    if (words_ != nullptr) munmap(words_, sizeof(PoseSlot));
    words_ = nullptr;
  }
  std::uint64_t Load(std::size_t word, std::memory_order order) const {
    return std::atomic_ref(words_[word]).load(order);
  }
  // None while the tracker writes.
  std::optional<PoseSlot> Copy() const {
    Words words{};
    const std::uint64_t count = Load(kCountWord, std::memory_order_acquire);
    // In order before the second look at the count; the thread sanitizer does not know fences.
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = Load(i, std::memory_order_acquire);
    if (count % 2 != 0 || Load(kCountWord, std::memory_order_relaxed) != count) return std::nullopt;
    words[kCountWord] = count;
    return std::bit_cast<PoseSlot>(words);
  }

  std::string source_;
  std::uint64_t* words_ = nullptr;  // The mapped slot; read only.
};

PoseStream::PoseStream(const std::string& source,
                       const PoseStreamOptions& options,
                       EventLog& events)
    : options_(options), source_(source), events_(events), track_(options.track, kMostPoses) {
  options.Validate();
  if (source.starts_with(kSharedMemory)) {
    input_ = std::make_unique<SlotInput>(source);
  } else {
    input_ = std::make_unique<LineInput>(source);
  }
  thread_ = std::jthread([this](const std::stop_token& stop) {
    input_->Read(stop, [this](const tl::expected<TimedPose, std::string>& pose) {
      std::string fault = pose ? Take(*pose) : pose.error();
      if (fault.empty()) return;
      events_.Add({std::chrono::system_clock::now(), EventKind::kPose, std::move(fault)});
    });
    Stop();
  });
}

PoseStream::~PoseStream() {
  thread_.request_stop();
  Stop();
}

tl::expected<TrackPose, std::string> PoseStream::At(UtcTime time) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(options_.wait_s), [&] {
    return is_over_ || track_.Reaches(time);
  });
  return track_.At(time);
}

void PoseStream::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
}

std::string PoseStream::Take(const TimedPose& pose) {
  if (const std::string fault = FaultOfPose(pose.camera_from_world); !fault.empty()) {
    return source_ + ": camera_from_world: expected " + fault;
  }
  std::string note;
  {
    const std::lock_guard lock(mutex_);
    if (!track_.IsEmpty() && SecondsFromTo(pose.time, track_.LatestTime()) > kMostDisorderS) {
      track_ = PoseTrack(options_.track, kMostPoses);
      note = source_ + ": the poses' times went back: those before are forgotten";
    }
    track_.Add(pose);
  }
  changed_.notify_all();
  return note;
}

}  // namespace pleinair
