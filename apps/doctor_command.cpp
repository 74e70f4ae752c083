#include "apps/doctor_command.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <GeographicLib/Config.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <assimp/version.h>
#include <ceres/version.h>
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <erfa.h>
#include <erfaextra.h>
#include <fmt/format.h>
#include <unistd.h>
#include <GeographicLib/Geoid.hpp>
#include <GeographicLib/MagneticModel.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "apps/message_text.h"
#include "apps/scratch_folder.h"
#include "apps/svg_chart.h"
#include "datasets/camera/camera.h"
#include "datasets/camera/camera_clock.h"
#include "datasets/camera/libcamera_camera.h"
#include "datasets/camera/v4l2_camera.h"
#include "datasets/video/video_writer.h"
#include "render/gl_context.h"
#include "render/software_driver.h"
#include "session/file_blob_store.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

enum class State { kOk, kMissing, kBroken };

struct Finding {
  std::string name;
  State state = State::kOk;
  std::string found;
  std::string advice;  // What to do; empty where nothing is to be done.
};

std::string_view Word(State state) {
  switch (state) {
    case State::kOk:
      return "ok";
    case State::kMissing:
      return "missing";
    case State::kBroken:
      break;
  }
  return "broken";
}

// `absent` is what it means that there is no such context: desktop OpenGL draws the composites, ES
// is what small boards have. The first of `libraries` that exists has its entry points; they are
// looked up only when one is called, so a context can be created without them.
Finding CheckGl(GlApi api,
                std::string name,
                State absent,
                std::initializer_list<const char*> libraries) {
  try {
    void* entry_points = nullptr;
    for (const char* library : libraries) {
      if (!entry_points) entry_points = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
    }
    if (!entry_points) throw std::runtime_error(std::string(*libraries.begin()) + " is not there");
    dlclose(entry_points);
    const HeadlessContext context(api);
    const GlDescription gl = context.Describe();
    const bool software = DrawsOnProcessor(gl.renderer.c_str());
    return {std::move(name),
            State::kOk,
            fmt::format("{}, {}{}", gl.renderer, gl.version, software ? " (in software)" : ""),
            ""};
  } catch (const std::exception& error) {
    return {std::move(name),
            absent,
            error.what(),
            "install the graphics card's driver, or for software drawing: apt install "
            "libegl1 libgles2 libopengl0 libgl1-mesa-dri"};
  }
}

Finding CheckProcessor() {
  std::string model;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) {
      model = line.substr(std::min(line.size(), line.find(':') + 2));
      break;
    }
  }
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  return {
      "processor",
      State::kOk,
      fmt::format("{} core{}{}", cores, cores == 1 ? "" : "s", model.empty() ? "" : ", " + model),
      ""};
}

// The sun moves 15 degrees an hour: a clock that is a minute off is a quarter degree of sun.
Finding CheckClock() {
  // No clock that was ever set says a year before this program's own.
  constexpr std::chrono::sys_days kEarliest = std::chrono::year(2025) / 1 / 1;
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const auto day = std::chrono::floor<std::chrono::days>(now);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(now - day);
  const std::string text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                                       static_cast<int>(date.year()),
                                       static_cast<unsigned>(date.month()),
                                       static_cast<unsigned>(date.day()),
                                       time.hours().count(),
                                       time.minutes().count(),
                                       time.seconds().count());
  if (now < kEarliest) {
    return {"clock", State::kBroken, text + ": was never set", "set it: date --utc --set=..."};
  }
  if (!ClockWarning().empty()) {
    return {"clock",
            State::kMissing,
            text + ": not synchronised; recordings carry their own times, live cameras need it",
            "apt install systemd-timesyncd (or chrony)"};
  }
  return {"clock", State::kOk, text + ", synchronised", ""};
}

// Cameras by their own interfaces, and devices that this user may not open.
std::vector<Finding> CheckCameras() {
  const CameraList list = ListCameras();
  std::vector<Finding> findings;
  for (const CameraDescription& camera : list.cameras) {
    if (camera.modes.empty()) {
      findings.push_back({"camera " + camera.device,
                          State::kMissing,
                          camera.name + ": no format that can be decoded",
                          "try it as libcamera's camera: pleinair cameras"});
    } else {
      findings.push_back({"camera " + camera.device,
                          State::kOk,
                          fmt::format("{}, {} modes", camera.name, camera.modes.size()),
                          ""});
    }
  }
  if (findings.empty()) {
    findings.push_back({"cameras",
                        State::kMissing,
                        "none; recordings need none",
                        "plug a camera in (in a container: pass its device on)"});
  }
  for (const std::string& device : list.not_permitted) {
    findings.push_back({"camera " + device,
                        State::kMissing,
                        "this user may not open it",
                        "join the group video: adduser $USER video, then log in again"});
  }
  if (LibcameraVersion().empty()) {
    findings.push_back({"libcamera",
                        State::kMissing,
                        "not built in; cameras of small boards need it",
                        "apt install libcamera-dev and build pleinair again"});
  } else if (!list.libcamera_failure.empty()) {
    findings.push_back({"libcamera",
                        State::kMissing,
                        LibcameraVersion() + ": " + list.libcamera_failure,
                        "see its log: LIBCAMERA_LOG_FILE=log pleinair cameras"});
  } else {
    findings.push_back({"libcamera", State::kOk, LibcameraVersion(), ""});
  }
  return findings;
}

// A picture through the encoder, as `run --video` and `record --store` need it.
Finding CheckEncoder(std::string name, std::string_view use, VideoCodec codec) {
  try {
    const ScratchFolder folder;
    VideoFormat format;
    format.codec = codec;
    format.width_px = 64;
    format.height_px = 48;
    VideoWriter(folder.Path() / "picture.mkv", format)
        .Add(Rgb8Image(format.width_px, format.height_px), std::chrono::nanoseconds(0));
    return {std::move(name), State::kOk, fmt::format("encodes, for {}", use), ""};
  } catch (const std::exception& error) {
    return {std::move(name),
            State::kMissing,
            fmt::format("not for {}: {}", use, error.what()),
            "apt install libavformat59 libswscale6 libavcodec59 (or libavcodec-extra59, its "
            "complete build)"};
  }
}

// Where other programs can take the composites as a camera's pictures.
Finding CheckLoopback() {
  const std::vector<std::string> devices = ListLoopbackDevices();
  if (devices.empty()) {
    return {"video output",
            State::kMissing,
            "no loopback device; only `run --stream v4l2:` needs one",
            "apt install v4l2loopback-dkms && modprobe v4l2loopback"};
  }
  return {"video output", State::kOk, fmt::format("{}", fmt::join(devices, ", ")), ""};
}

// Space in the current folder, below which outputs and recordings go by default.
Finding CheckSpace() {
  // An hour of 640x480 at 30 pictures a second, as PNG.
  constexpr std::uintmax_t kEnoughBytes = 30ULL << 30;
  std::error_code error;
  const fs::space_info space = fs::space(".", error);
  if (error) return {"space", State::kMissing, error.message(), "change to another folder"};
  const std::string found = fmt::format(
      "{:.1f} GiB free here", static_cast<double>(space.available) / static_cast<double>(1 << 30));
  if (space.available < kEnoughBytes) {
    return {"space",
            State::kMissing,
            found + ": less than an hour of 640x480 at 30 pictures a second needs, as PNG",
            "make room, or record with --store ffv1 or --every"};
  }
  return {"space", State::kOk, found, ""};
}

// A data set of GeographicLib's: in no Debian package, and only some uses need it.
Finding CheckModel(std::string name,
                   const std::string& folder,
                   std::string_view extension,
                   std::string_view purpose,
                   std::string_view command) {
  std::vector<std::string> models;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == extension) models.push_back(entry->path().stem().string());
  }
  if (models.empty()) {
    return {std::move(name),
            State::kMissing,
            fmt::format("none in {}; only needed {}", folder, purpose),
            fmt::format("apt install geographiclib-tools && {}", command)};
  }
  std::sort(models.begin(), models.end());
  return {
      std::move(name), State::kOk, fmt::format("{} in {}", fmt::join(models, ", "), folder), ""};
}

Finding CheckCache() {
  // A prepared site takes some tens of megabytes; the cache holds kDefaultCacheLimitBytes at most.
  constexpr std::uintmax_t kEnoughBytes = 256ULL << 20;
  try {
    const fs::path folder = DefaultCacheFolder();
    fs::path present = folder;
    std::error_code error;
    while (!fs::exists(present, error) && present.has_relative_path()) {
      present = present.parent_path();
    }
    if (access(present.c_str(), W_OK | X_OK) != 0 || !fs::is_directory(present, error)) {
      return {"cache",
              State::kMissing,
              fmt::format("{}: not writable; every run prepares its site again", folder.string()),
              "give --cache DIR, set XDG_CACHE_HOME, or correct the permissions"};
    }
    const fs::space_info space = fs::space(present, error);
    const std::string found =
        error ? folder.string()
              : fmt::format("{}, {:.1f} GiB free",
                            folder.string(),
                            static_cast<double>(space.available) / static_cast<double>(1ULL << 30));
    if (!error && space.available < kEnoughBytes) {
      return {
          "cache", State::kMissing, found + ": too little to keep a prepared site", "make room"};
    }
    return {"cache", State::kOk, found, ""};
  } catch (const std::exception& error) {
    return {"cache", State::kMissing, error.what(), "give --cache DIR"};
  }
}

Finding CheckEmbree() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device) {
    return {"Embree",
            State::kBroken,
            fmt::format("no ray-casting device (error {})",
                        static_cast<int>(rtcGetDeviceError(nullptr))),
            "a processor with SSE2 is needed"};
  }
  const auto version = fmt::format("{}.{}.{}",
                                   rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                                   rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
                                   rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
  rtcReleaseDevice(device);
  return {"Embree", State::kOk, version, ""};
}

Finding CheckGnuplot() {
  try {
    ChartSeries line{"y", "#000000"};
    line.points = {{ChartValue::Exact(0.0), ChartValue::Exact(0.0), ""},
                   {ChartValue::Exact(1.0), ChartValue::Exact(1.0), ""}};
    DrawChart({"a line", {"x"}, {"y"}, {std::move(line)}});
    return {"gnuplot", State::kOk, "draws charts", ""};
  } catch (const std::runtime_error& error) {
    return {"gnuplot",
            State::kMissing,
            std::string(error.what()) + "; reports are without charts",
            "apt install gnuplot-nox"};
  }
}

std::vector<Finding> CheckEverything() {
  std::vector<Finding> findings = {
      {"pleinair", State::kOk, PLEINAIR_VERSION, ""},
      CheckGl(GlApi::kDesktop45, "OpenGL 4.5", State::kBroken, {"libOpenGL.so.0", "libGL.so.1"}),
      CheckGl(GlApi::kEs31, "OpenGL ES 3.1", State::kMissing, {"libGLESv2.so.2"}),
      CheckProcessor(),
      CheckClock(),
      CheckCache(),
      CheckGnuplot(),
  };
  for (Finding& camera : CheckCameras()) findings.push_back(std::move(camera));
  findings.push_back(CheckLoopback());
  findings.push_back(CheckEncoder("FFV1", "recordings", VideoCodec::kFfv1));
  findings.push_back(CheckEncoder("H.264", "videos to look at", VideoCodec::kH264));
  findings.push_back(CheckSpace());
  findings.push_back(CheckModel("magnetic model",
                                GeographicLib::MagneticModel::DefaultMagneticPath(),
                                ".wmm",
                                "to turn compass headings into true north",
                                "geographiclib-get-magnetic wmm2020"));
  findings.push_back(CheckModel("geoid",
                                GeographicLib::Geoid::DefaultGeoidPath(),
                                ".pgm",
                                "to turn heights above sea level into ellipsoid heights",
                                "geographiclib-get-geoids egm96-5"));
  findings.push_back(CheckEmbree());
  findings.push_back({"OpenCV", State::kOk, cv::getVersionString(), ""});
  findings.push_back({"Ceres", State::kOk, CERES_VERSION_STRING, ""});
  findings.push_back(
      {"assimp",
       State::kOk,
       fmt::format("{}.{}.{}", aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch()),
       ""});
  findings.push_back({"OpenEXR", State::kOk, OPENEXR_VERSION_STRING, ""});
  findings.push_back({"ERFA", State::kOk, eraVersion(), ""});
  findings.push_back({"GeographicLib", State::kOk, GEOGRAPHICLIB_VERSION_STRING, ""});
  return findings;
}

std::string AsJson(const std::vector<Finding>& findings, bool all_well) {
  nlohmann::json checks = nlohmann::json::array();
  for (const Finding& finding : findings) {
    checks.push_back({{"name", finding.name},
                      {"state", Word(finding.state)},
                      {"found", finding.found},
                      {"advice", finding.advice}});
  }
  const nlohmann::json report = {
      {"version", PLEINAIR_VERSION}, {"all_well", all_well}, {"checks", checks}};
  // Names of devices and drivers are foreign text: what is not UTF-8 in them is replaced.
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

std::string AsText(const std::vector<Finding>& findings) {
  std::size_t name_width = 0;
  for (const Finding& finding : findings) name_width = std::max(name_width, finding.name.size());
  std::string text;
  for (const Finding& finding : findings) {
    text += fmt::format("{:<7}  {:<{}}  {}",
                        Word(finding.state),
                        MessageText(finding.name),
                        name_width,
                        MessageText(finding.found));
    if (!finding.advice.empty()) text += ": " + finding.advice;
    text += '\n';
  }
  return text;
}

}  // namespace

std::string RunDoctorCommand(bool json, bool* all_well) {
  const std::vector<Finding> findings = CheckEverything();
  *all_well = std::none_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.state == State::kBroken;
  });
  return json ? AsJson(findings, *all_well) : AsText(findings);
}

}  // namespace pleinair
