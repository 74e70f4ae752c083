// pleinair-camera-stand-in: runs a command with a recorded sequence as its camera.

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <new>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/camera_stand_in/device_state.h"
#include "apps/camera_stand_in/fault_list.h"
#include "apps/camera_stand_in/pictures_file.h"
#include "apps/camera_stand_in/shim/controls.h"
#include "apps/message_text.h"
#include "apps/one_of.h"
#include "datasets/sequence.h"

namespace pleinair::stand_in {
namespace {

constexpr int kBadInput = 2;
constexpr int kCannotRun = 126;
constexpr int kNoSuchCommand = 127;
constexpr int kKilledBySignal = 128;
constexpr int kMostPixels = 1 << 26;

constexpr double kLeastRateHz = 0.01;
constexpr double kMostRateHz = 1000.0;

struct Options {
  std::string sequence;
  double rate_hz = 30.0;
  int loops = 1;
  std::string pictures;
  std::string size;
  std::string format = "YUYV";
  std::string faults;
  int number = 90;
  int control_delay = 2;
  bool is_multi_planar = false;
  std::uint32_t ycbcr_encoding = V4L2_YCBCR_ENC_601;
  std::uint32_t quantization = V4L2_QUANTIZATION_LIM_RANGE;
};

const std::map<std::string, std::uint32_t> kFormats{
    {"YUYV", V4L2_PIX_FMT_YUYV},
    {"NV12", V4L2_PIX_FMT_NV12},
    {"MJPEG", V4L2_PIX_FMT_MJPEG},
    {"GREY", V4L2_PIX_FMT_GREY},
    {"RGB24", V4L2_PIX_FMT_RGB24},
    {"SRGGB8", V4L2_PIX_FMT_SRGGB8},
    {"SRGGB10", V4L2_PIX_FMT_SRGGB10},
    {"SRGGB10P", V4L2_PIX_FMT_SRGGB10P},
    {"SRGGB12", V4L2_PIX_FMT_SRGGB12},
    {"SRGGB12P", V4L2_PIX_FMT_SRGGB12P},
};

// Keeps the frames FIRST to LAST.
void KeepPictures(const std::string& text, Sequence& sequence) {
  if (text.empty()) return;
  unsigned long first = 0;
  unsigned long last = sequence.frames.size() - 1;
  int read = 0;
  const int fields = std::sscanf(text.c_str(), "%lu%n:%lu%n", &first, &read, &last, &read);
  if (fields < 1 || static_cast<std::size_t>(read) != text.size() || text[0] == '-' ||
      first > last || last >= sequence.frames.size()) {
    throw std::invalid_argument("--pictures " + text + ": expected FIRST[:LAST] from 0 to " +
                                std::to_string(sequence.frames.size() - 1));
  }
  auto& frames = sequence.frames;
  frames = {frames.begin() + static_cast<std::ptrdiff_t>(first),
            frames.begin() + static_cast<std::ptrdiff_t>(last) + 1};
}

std::optional<Size> ParseSize(const std::string& text, Size own) {
  if (text.empty()) return std::nullopt;
  Size size;
  int read = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &size.width, &size.height, &read) != 2 ||
      static_cast<std::size_t>(read) != text.size() || size.width < 16 || size.height < 16 ||
      std::int64_t{size.width} * size.height > kMostPixels) {
    throw std::invalid_argument("--size " + text + ": expected WIDTHxHEIGHT in pixels, such as " +
                                std::to_string(own.width) + "x" + std::to_string(own.height));
  }
  return size;
}

// The sequence's own size first, then what cameras usually have of its shape.
void ListSizes(Size own, std::optional<Size> wanted, DeviceState& state) {
  const auto add = [&](Size size) {
    auto* const end = state.sizes.begin() + state.size_count;
    if (std::find(state.sizes.begin(), end, size) == end) {
      state.sizes[static_cast<std::size_t>(state.size_count++)] = size;
    }
  };
  add(own);
  if (wanted) add(*wanted);
  for (const int width : {320, 640, 1280, 1920}) {
    const int height =
        static_cast<int>(std::lround(width * static_cast<double>(own.height) / own.width));
    if (height % 2 == 0 && width * own.height == height * own.width) add({width, height});
  }
  if (state.size_count == 1) add({own.width / 4 * 2, own.height / 4 * 2});
}

Interval IntervalOf(double rate_hz) {
  auto milli = static_cast<std::uint32_t>(std::lround(rate_hz * 1000.0));
  const std::uint32_t common = std::gcd(milli, 1000u);
  return {1000u / common, milli / common};
}

void ListIntervals(double rate_hz, DeviceState& state) {
  state.default_interval = IntervalOf(rate_hz);
  state.intervals[static_cast<std::size_t>(state.interval_count++)] = state.default_interval;
  for (const double rate : {5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 50.0, 60.0}) {
    const Interval interval = IntervalOf(rate);
    if (interval == state.default_interval) continue;
    state.intervals[static_cast<std::size_t>(state.interval_count++)] = interval;
  }
}

// The block that all processes of the command map.
DeviceState& MakeState(int fd) {
  if (fd < 0 || ftruncate(fd, sizeof(DeviceState)) != 0) {
    throw std::runtime_error(std::string("no shared memory: ") + std::strerror(errno));
  }
  void* const block = mmap(nullptr, sizeof(DeviceState), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (block == MAP_FAILED) {
    throw std::runtime_error(std::string("no shared memory: ") + std::strerror(errno));
  }
  DeviceState& state = *new (block) DeviceState;
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&state.mutex, &attributes);
  pthread_mutexattr_destroy(&attributes);
  return state;
}

std::int64_t NowNs(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

// Path under which other processes of the user open a descriptor of this one.
std::string PathOf(int fd) {
  return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(fd);
}

void SetUp(const Options& options, DeviceState& state) {
  if (!(options.rate_hz >= kLeastRateHz && options.rate_hz <= kMostRateHz)) {
    throw std::invalid_argument("--rate: expected 0.01 to 1000 pictures a second");
  }
  const FaultList faults = ParseFaults(options.faults);
  Sequence sequence = ReadSequence(options.sequence, SequencePoses::kMayBeAbsent);
  KeepPictures(options.pictures, sequence);
  const Size own{sequence.intrinsics.width_px, sequence.intrinsics.height_px};
  const std::optional<Size> size = ParseSize(options.size, own);

  const std::string pictures = PathOf(WritePicturesFile(sequence, size, state));
  std::snprintf(state.pictures_path, sizeof state.pictures_path, "%s", pictures.c_str());
  state.number = state.number_given = options.number;
  state.pictures_to_play = std::int64_t{options.loops} * state.picture_count;
  state.first_utc_ns = sequence.frames.front().time.time_since_epoch().count();
  ListSizes(own, size, state);
  ListIntervals(options.rate_hz, state);
  state.default_format = state.format = {kFormats.at(options.format), size.value_or(own)};
  state.interval = state.default_interval;
  state.ycbcr_encoding = options.ycbcr_encoding;
  state.quantization = options.quantization;
  state.control_delay = options.control_delay;
  state.is_multi_planar = options.is_multi_planar;
  ResetControls(state);
  state.priority = V4L2_PRIORITY_DEFAULT;
  std::copy(faults.faults.begin(), faults.faults.end(), state.faults.begin());
  state.fault_count = static_cast<int>(faults.faults.size());
  state.faults_count_pictures = faults.count_pictures;
  state.realtime_minus_monotonic_ns = state.first_utc_ns - NowNs(CLOCK_MONOTONIC);
}

// Beside this program, in the build folder as where it is installed.
std::string ShimPath() {
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path shim = folder / PLEINAIR_SHIM_FROM_PROGRAM;
  if (!std::filesystem::exists(shim)) {
    throw std::runtime_error(shim.lexically_normal().string() +
                             ": expected the stand-in's preload library, found nothing");
  }
  return shim.lexically_normal().string();
}

void Preload(const std::string& shim) {
  const char* const others = std::getenv("LD_PRELOAD");
  const std::string all = others != nullptr && *others != '\0' ? shim + ":" + others : shim;
  setenv("LD_PRELOAD", all.c_str(), 1);
}

// Runs the command to its end, and hands signals on to it; returns its exit code.
int Run(std::vector<char*> command) {
  sigset_t handled;
  sigset_t before;
  sigemptyset(&handled);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGCHLD}) {
    sigaddset(&handled, signal);
  }
  sigprocmask(SIG_BLOCK, &handled, &before);
  const pid_t own = getpid();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // Its camera is gone.
    if (getppid() != own) _exit(kCannotRun);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    execvp(command[0], command.data());
    const int code = errno == ENOENT ? kNoSuchCommand : kCannotRun;
    std::fprintf(stderr,
                 "pleinair-camera-stand-in: %s: %s\n",
                 MessageText(command[0]).c_str(),
                 std::strerror(errno));
    _exit(code);
  }
  for (;;) {
    siginfo_t info{};
    const int signal = sigwaitinfo(&handled, &info);
    if (signal == SIGCHLD) {
      int status = 0;
      if (waitpid(child, &status, WNOHANG) != child) continue;
      if (WIFEXITED(status)) return WEXITSTATUS(status);
      if (WIFSIGNALED(status)) return kKilledBySignal + WTERMSIG(status);
    } else if (signal > 0 && info.si_code != SI_KERNEL) {  // A terminal's reach the command, too.
      kill(child, signal);
    }
  }
}

void AddOptions(CLI::App& app, Options& options) {
  app.add_option("sequence", options.sequence, "Folder with sequence.json")->required();
  app.add_option(
      "--rate", options.rate_hz, "Pictures a second, unless the command asks for others");
  app.add_option("--loop", options.loops, "How often to play it; 0: without end")
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--pictures", options.pictures, "FIRST[:LAST] (default: to the last), from 0");
  app.add_option("--size", options.size, "WIDTHxHEIGHT at first (default: the sequence's)");
  std::vector<std::string> names;
  names.reserve(std::size(kFormats));
  for (const auto& [name, code] : kFormats) names.push_back(name);
  app.add_option("--format", options.format, "Pixel format at first")->check(CLI::IsMember(names));
  app.add_option(
      "--fault",
      options.faults,
      "NAME@SECONDS,... of streaming, or NAME@Np,... after N pictures that were read; NAME is "
      "random:SEED:COUNT, or one of " +
          FaultNames());
  app.add_option("--number", options.number, "N of /dev/videoN")->check(CLI::Range(0, 255));
  app.add_option("--control-delay",
                 options.control_delay,
                 "Frames from the last one captured when a control is set to the first that has it")
      ->check(CLI::Range(1, kMaxControlDelay));
  app.add_flag("--multi-planar", options.is_multi_planar, "Multi-planar buffers, of one plane");
  app.add_option("--ycbcr",
                 options.ycbcr_encoding,
                 "Matrix of YUYV and NV12, by its BT standard: 601, 709 or 2020")
      ->transform(OneOf<std::uint32_t>({{"601", V4L2_YCBCR_ENC_601},
                                        {"709", V4L2_YCBCR_ENC_709},
                                        {"2020", V4L2_YCBCR_ENC_BT2020}}))
      ->type_name("MATRIX")
      ->default_str("601");
  app.add_option("--range", options.quantization, "Range of YUYV and NV12: limited or full")
      ->transform(OneOf<std::uint32_t>(
          {{"limited", V4L2_QUANTIZATION_LIM_RANGE}, {"full", V4L2_QUANTIZATION_FULL_RANGE}}))
      ->type_name("RANGE")
      ->default_str("limited");
}

int Refuse(const std::string& reason) {
  std::fprintf(stderr, "pleinair-camera-stand-in: %s\n", MessageText(reason).c_str());
  return kBadInput;
}

int Main(int argc, char** argv) {
  // What follows `--` is the command's.
  char** const separator = std::find_if(
      argv + 1, argv + argc, [](const char* word) { return std::strcmp(word, "--") == 0; });
  const int own_count = static_cast<int>(separator - argv);
  std::vector<char*> command(separator == argv + argc ? separator : separator + 1, argv + argc);

  CLI::App app(
      "Runs a command with a recorded sequence as the camera /dev/videoN.\n"
      "Usage: pleinair-camera-stand-in SEQUENCE [OPTIONS] -- COMMAND [ARGUMENTS]");
  app.name("pleinair-camera-stand-in");
  app.footer(
      "Example: pleinair-camera-stand-in datasets/samples/courtyard --loop 0 -- pleinair cameras");
  app.set_version_flag("--version", PLEINAIR_VERSION);
  app.option_defaults()->always_capture_default();
  Options options;
  AddOptions(app, options);
  try {
    app.parse(own_count, argv);
    if (command.empty()) throw std::invalid_argument("expected -- COMMAND after the options");
    command.push_back(nullptr);
    const std::string shim = ShimPath();
    const int state_fd = memfd_create("pleinair-camera", MFD_CLOEXEC);
    SetUp(options, MakeState(state_fd));
    setenv(kStateVariable, PathOf(state_fd).c_str(), 1);
    Preload(shim);
    return Run(std::move(command));
  } catch (const CLI::Success& done) {
    return app.exit(done);  // --help, --version
  } catch (const std::exception& error) {
    return Refuse(error.what());
  }
}

}  // namespace
}  // namespace pleinair::stand_in

int main(int argc, char** argv) { return pleinair::stand_in::Main(argc, argv); }
