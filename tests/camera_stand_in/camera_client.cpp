// A camera program of the test's own: it knows V4L2 and nothing of pleinair. It writes what it sees
// as one JSON object a line.
//
// Usage: camera_client list|rules|stream|opencv DEVICE [KEY=VALUE...]

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>

namespace {

using Json = nlohmann::json;

std::map<std::string, std::string> given;

int Number(const std::string& key, int otherwise) {
  return given.contains(key) ? std::stoi(given[key]) : otherwise;
}

void Print(const Json& line) {
  std::puts(line.dump().c_str());
  std::fflush(stdout);
}

std::int64_t ClockNs(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

// The wall clock less the monotonic one, read without an interruption between them.
std::int64_t WallOffsetNs() {
  std::int64_t least = 1'000'000'000;
  std::int64_t offset = 0;
  for (int i = 0; i < 100; ++i) {
    const std::int64_t before = ClockNs(CLOCK_MONOTONIC);
    const std::int64_t wall = ClockNs(CLOCK_REALTIME);
    const std::int64_t after = ClockNs(CLOCK_MONOTONIC);
    if (after - before >= least) continue;
    least = after - before;
    offset = wall - (before + after) / 2;
  }
  return offset;
}

std::uint32_t PixelFormat() {
  const std::string name = given.contains("format") ? given["format"] : "RGB3";
  return v4l2_fourcc(name[0], name[1], name[2], name[3]);
}

std::string Name(std::uint32_t code) {
  std::string name(4, ' ');
  std::memcpy(name.data(), &code, 4);
  return name;
}

// 0, or the errno.
template <typename T>
int Call(int fd, unsigned long request, T* argument) {
  return ioctl(fd, request, argument) == 0 ? 0 : errno;
}

int List(const std::string& device) {
  const int fd = open(device.c_str(), O_RDWR);
  v4l2_capability capability{};
  if (fd < 0 || Call(fd, VIDIOC_QUERYCAP, &capability) != 0) return 1;
  Print({{"card", reinterpret_cast<char*>(capability.card)},
         {"bus", reinterpret_cast<char*>(capability.bus_info)}});
  v4l2_fmtdesc format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; Call(fd, VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    Json line{{"format", Name(format.pixelformat)}, {"sizes", Json::array()}};
    v4l2_frmsizeenum size{};
    size.pixel_format = format.pixelformat;
    for (; Call(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      v4l2_frmivalenum interval{};
      interval.pixel_format = format.pixelformat;
      interval.width = size.discrete.width;
      interval.height = size.discrete.height;
      Json rates = Json::array();
      for (; Call(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
        rates.push_back(static_cast<double>(interval.discrete.denominator) /
                        interval.discrete.numerator);
      }
      line["sizes"].push_back({size.discrete.width, size.discrete.height, rates});
    }
    Print(line);
  }
  v4l2_query_ext_ctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (Call(fd, VIDIOC_QUERY_EXT_CTRL, &control) == 0) {
    Json line{{"control", control.name}, {"normal", control.default_value}};
    v4l2_control value{control.id, 0};
    if (Call(fd, VIDIOC_G_CTRL, &value) == 0) line["value"] = value.value;
    Print(line);
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return 0;
}

bool SetFormat(int fd, v4l2_pix_format& pix) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (Call(fd, VIDIOC_G_FMT, &format) != 0) return false;
  format.fmt.pix.pixelformat = PixelFormat();
  format.fmt.pix.width = Number("width", static_cast<int>(format.fmt.pix.width));
  format.fmt.pix.height = Number("height", static_cast<int>(format.fmt.pix.height));
  if (Call(fd, VIDIOC_S_FMT, &format) != 0) return false;
  pix = format.fmt.pix;
  return true;
}

int Request(int fd, std::uint32_t count) {
  v4l2_requestbuffers request{};
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  request.count = count;
  return Call(fd, VIDIOC_REQBUFS, &request);
}

int Poll(int fd, short events, int timeout_ms) {
  pollfd one{fd, events, 0};
  poll(&one, 1, timeout_ms);
  return one.revents;
}

// What V4L2 says of calls out of turn.
int Rules(const std::string& device) {
  const int first = open(device.c_str(), O_RDWR | O_NONBLOCK);
  const int second = open(device.c_str(), O_RDWR | O_NONBLOCK);
  int capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format pix{};
  v4l2_std_id standard{};
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  Json line;
  line["poll_idle"] = Poll(first, POLLIN, 0);
  line["stream_without_buffers"] = Call(first, VIDIOC_STREAMON, &capture);
  line["unknown"] = Call(first, VIDIOC_G_STD, &standard);
  line["format"] = SetFormat(first, pix);
  line["buffers"] = Request(first, 4);
  line["second_buffers"] = Request(second, 4);
  line["second_format"] = SetFormat(second, pix);
  line["streamon"] = Call(first, VIDIOC_STREAMON, &capture);
  line["poll_empty"] = Poll(first, POLLIN, 50);
  line["dequeue_empty"] = Call(first, VIDIOC_DQBUF, &buffer);
  buffer.index = 0;
  line["queue"] = Call(first, VIDIOC_QBUF, &buffer);
  line["queue_twice"] = Call(first, VIDIOC_QBUF, &buffer);
  line["poll_filled"] = Poll(first, POLLIN, 10'000);
  line["free_streaming"] = Request(first, 0);
  line["streamoff"] = Call(first, VIDIOC_STREAMOFF, &capture);
  line["free"] = Request(first, 0);
  line["second_then"] = Request(second, 2);
  close(second);
  line["first_then"] = Request(first, 2);
  Print(line);
  return 0;
}

class Stream {
 public:
  // Whether it streams now.
  bool Start(const std::string& device) {
    fd_ = open(device.c_str(), O_RDWR);
    if (fd_ < 0) return false;
    v4l2_event_subscription subscription{};
    subscription.type = V4L2_EVENT_SOURCE_CHANGE;
    Call(fd_, VIDIOC_SUBSCRIBE_EVENT, &subscription);
    v4l2_pix_format pix{};
    if (!SetFormat(fd_, pix) || Request(fd_, 4) != 0) return false;
    Print({{"width", pix.width},
           {"height", pix.height},
           {"device", device},
           {"encoding", pix.ycbcr_enc},
           {"quantization", pix.quantization}});
    for (std::uint32_t i = 0; i < 4; ++i) {
      v4l2_buffer buffer = Blank();
      buffer.index = i;
      if (Call(fd_, VIDIOC_QUERYBUF, &buffer) != 0) return false;
      void* memory =
          mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, buffer.m.offset);
      if (memory == MAP_FAILED) return false;
      memory_.push_back({static_cast<unsigned char*>(memory), buffer.length});
      if (Call(fd_, VIDIOC_QBUF, &buffer) != 0) return false;
    }
    int capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    return Call(fd_, VIDIOC_STREAMON, &capture) == 0;
  }

  // 0, or the errno that ended the stream.
  int Next() {
    const int events = Poll(fd_, POLLIN | POLLPRI, 20'000);
    if ((events & POLLPRI) != 0) {
      v4l2_event event{};
      if (Call(fd_, VIDIOC_DQEVENT, &event) == 0) Print({{"event", event.type}});
      v4l2_format format{};
      format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      Call(fd_, VIDIOC_G_FMT, &format);
      Print({{"new_width", format.fmt.pix.width}, {"new_height", format.fmt.pix.height}});
    }
    v4l2_buffer buffer = Blank();
    if (const int error = Call(fd_, VIDIOC_DQBUF, &buffer)) {
      Print({{"error", error}, {"poll", events}, {"at_ns", ClockNs(CLOCK_MONOTONIC)}});
      return error;
    }
    const std::int64_t time_ns =
        buffer.timestamp.tv_sec * std::int64_t{1'000'000'000} + buffer.timestamp.tv_usec * 1000;
    const auto [data, length] = memory_[buffer.index];
    double sum = 0.0;
    for (std::uint32_t i = 0; i < buffer.bytesused; ++i) sum += data[i];
    Print({{"sequence", buffer.sequence},
           {"time_ns", time_ns},
           {"offset_ns", WallOffsetNs()},
           {"flags", buffer.flags},
           {"bytes", buffer.bytesused},
           {"mean", sum / std::max(buffer.bytesused, 1u)}});
    if (given.contains("out")) {
      std::ofstream file(given["out"] + "/" + std::to_string(count_) + ".raw", std::ios::binary);
      file.write(reinterpret_cast<char*>(data), buffer.bytesused);
    }
    if (count_ == Number("hold_at", -1)) usleep(500'000);  // And with it the other buffers.
    if (count_ == Number("set_at", -1)) SetControls();
    ++count_;
    const int error = Call(fd_, VIDIOC_QBUF, &buffer);
    return error == EIO || error == ENODEV ? 0 : error;  // The next call reports an interruption.
  }

  // How many pictures it has had, over all interruptions.
  int Count() const { return count_; }

  void Stop() {
    for (const auto& [data, length] : memory_) munmap(data, length);
    memory_.clear();
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }

 private:
  static v4l2_buffer Blank() {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }

  // Locks the exposure, and sets its time.
  void SetControls() {
    v4l2_control automatic{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL};
    v4l2_control exposure{V4L2_CID_EXPOSURE_ABSOLUTE, Number("exposure", 100)};
    const std::int64_t before = ClockNs(CLOCK_MONOTONIC);
    int error = Call(fd_, VIDIOC_S_CTRL, &automatic);
    if (error == 0) error = Call(fd_, VIDIOC_S_CTRL, &exposure);
    const std::int64_t after = ClockNs(CLOCK_MONOTONIC);
    v4l2_control now{V4L2_CID_EXPOSURE_ABSOLUTE, 0};
    Call(fd_, VIDIOC_G_CTRL, &now);
    Print({{"set", error}, {"value", now.value}, {"before_ns", before}, {"after_ns", after}});
  }

  int fd_ = -1;
  int count_ = 0;
  std::vector<std::pair<unsigned char*, std::uint32_t>> memory_;
};

// The device that has the stand-in's name, whatever its number; empty: none now.
std::string FindDevice() {
  for (int number = 0; number < 256; ++number) {
    const std::string device = "/dev/video" + std::to_string(number);
    const int fd = open(device.c_str(), O_RDWR);
    if (fd < 0) continue;
    v4l2_capability capability{};
    const bool found =
        Call(fd, VIDIOC_QUERYCAP, &capability) == 0 &&
        std::strcmp(reinterpret_cast<char*>(capability.bus_info), "stand-in:90") == 0;
    close(fd);
    if (found) return device;
  }
  return "";
}

// To the end of the stream, or to pictures=N; with recover=1 across whatever interrupts it.
int Run(std::string device) {
  Stream stream;
  const int most = Number("pictures", std::numeric_limits<int>::max());
  for (int interruptions = 0; interruptions < 200;) {
    if (!stream.Start(device)) {
      Print({{"open_error", errno}});
      if (Number("recover", 0) == 0) return 1;
      stream.Stop();
      usleep(20'000);
      if (const std::string found = FindDevice(); !found.empty()) device = found;
      continue;
    }
    int error = 0;
    while (error == 0 && stream.Count() < most) error = stream.Next();
    stream.Stop();
    if (error == 0 || error == EPIPE) return 0;
    if (Number("recover", 0) == 0) return 1;
    ++interruptions;
  }
  return 1;
}

int OpenCv(const std::string& device) {
  cv::VideoCapture capture(device, cv::CAP_V4L2);
  cv::Mat picture;
  int count = 0;
  while (capture.read(picture)) ++count;
  Print({{"opened", capture.isOpened()}, {"count", count}, {"width", picture.cols}});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    given[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  const std::string mode = argv[1];
  if (mode == "list") return List(argv[2]);
  if (mode == "rules") return Rules(argv[2]);
  if (mode == "opencv") return OpenCv(argv[2]);
  return Run(argv[2]);
}
