#include "render/gl_context.h"

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "render/internal/current_context.h"

namespace pleinair {
namespace {

constexpr const char* kWhatToInstall =
    "; install a GPU driver with EGL, or libegl1 and libgl1-mesa-dri for software OpenGL";

std::string EglErrorText() {
  const EGLint code = eglGetError();
  struct Named {
    EGLint code;
    const char* name;
  };
  static constexpr std::array<Named, 9> kNames{{{EGL_SUCCESS, "no error given"},
                                                {EGL_NOT_INITIALIZED, "EGL_NOT_INITIALIZED"},
                                                {EGL_BAD_ACCESS, "EGL_BAD_ACCESS"},
                                                {EGL_BAD_ALLOC, "EGL_BAD_ALLOC"},
                                                {EGL_BAD_ATTRIBUTE, "EGL_BAD_ATTRIBUTE"},
                                                {EGL_BAD_CONFIG, "EGL_BAD_CONFIG"},
                                                {EGL_BAD_MATCH, "EGL_BAD_MATCH"},
                                                {EGL_BAD_PARAMETER, "EGL_BAD_PARAMETER"},
                                                {EGL_CONTEXT_LOST, "EGL_CONTEXT_LOST"}}};
  for (const Named& named : kNames) {
    if (named.code == code) return named.name;
  }
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "EGL error 0x%x", static_cast<unsigned>(code));
  return text.data();
}

[[noreturn]] void Fail(const std::string& step) {
  throw std::runtime_error("OpenGL without a window: " + step + ": " + EglErrorText() +
                           kWhatToInstall);
}

bool HasExtension(const char* list, std::string_view name) {
  if (list == nullptr) return false;
  std::string_view rest(list);
  while (!rest.empty()) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == name) return true;
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  return false;
}

template <typename Function>
Function EglFunction(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// Displays that need no window system, the preferred first: Mesa's surfaceless platform (a GPU if
// there is one, else software), then EGL devices (other drivers).
std::vector<EGLDisplay> CandidateDisplays() {
  std::vector<EGLDisplay> displays;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto get_display = EglFunction<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr || !HasExtension(client, "EGL_EXT_platform_base")) return displays;
  if (HasExtension(client, "EGL_MESA_platform_surfaceless")) {
    const EGLDisplay display =
        get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY) displays.push_back(display);
  }
  const auto query_devices = EglFunction<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (query_devices != nullptr && HasExtension(client, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count);
    for (EGLint i = 0; i < count; ++i) {
      const EGLDisplay display = get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
      if (display != EGL_NO_DISPLAY) displays.push_back(display);
    }
  }
  return displays;
}

EGLContext CreateContext(EGLDisplay display, GlApi api) {
  const bool desktop = api == GlApi::kDesktop45;
  if (eglBindAPI(desktop ? EGL_OPENGL_API : EGL_OPENGL_ES_API) != EGL_TRUE) return EGL_NO_CONTEXT;
  // No surface is ever made, so a context without a config is used where available.
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!HasExtension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_no_config_context")) {
    const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE,
                                       0,
                                       EGL_RENDERABLE_TYPE,
                                       desktop ? EGL_OPENGL_BIT : EGL_OPENGL_ES3_BIT,
                                       EGL_NONE};
    EGLint count = 0;
    if (eglChooseConfig(display, wanted.data(), &config, 1, &count) != EGL_TRUE || count < 1) {
      return EGL_NO_CONTEXT;
    }
  }
  const std::array<EGLint, 7> desktop_attributes{EGL_CONTEXT_MAJOR_VERSION,
                                                 4,
                                                 EGL_CONTEXT_MINOR_VERSION,
                                                 5,
                                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                 EGL_NONE};
  const std::array<EGLint, 5> es_attributes{
      EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 1, EGL_NONE};
  return eglCreateContext(
      display, config, EGL_NO_CONTEXT, desktop ? desktop_attributes.data() : es_attributes.data());
}

// Through EGL, because libepoxy's header and EGL's own cannot be included in one file.
std::string GlString(unsigned name) {
  using GetString = const unsigned char* (*)(unsigned);
  const auto get_string = EglFunction<GetString>("glGetString");
  const unsigned char* text = get_string == nullptr ? nullptr : get_string(name);
  return text == nullptr ? std::string("unknown") : reinterpret_cast<const char*>(text);
}

}  // namespace

struct HeadlessContext::Impl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

HeadlessContext::HeadlessContext(GlApi api) : impl_(std::make_unique<Impl>()) {
  const char* wanted =
      api == GlApi::kDesktop45 ? "an OpenGL 4.5 core context" : "an OpenGL ES 3.1 context";
  const std::vector<EGLDisplay> displays = CandidateDisplays();
  if (displays.empty()) {
    Fail("no EGL display without a window system (surfaceless or device platform)");
  }
  std::string failed_step;
  for (const EGLDisplay display : displays) {
    if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
      failed_step = "eglInitialize found no usable driver";
      continue;
    }
    if (!HasExtension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
      failed_step = "the driver lacks EGL_KHR_surfaceless_context";
      continue;
    }
    const EGLContext context = CreateContext(display, api);
    if (context == EGL_NO_CONTEXT) {
      failed_step = std::string("eglCreateContext gave no ") + (wanted + 3);
      continue;
    }
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE) {
      eglDestroyContext(display, context);
      failed_step = "eglMakeCurrent refused the context";
      continue;
    }
    impl_->display = display;
    impl_->context = context;
    return;
  }
  Fail(failed_step);
}

HeadlessContext::~HeadlessContext() {
  // The display stays initialised: EGL shares it with every other context of this process.
  if (CurrentContext() == impl_->context) {
    eglMakeCurrent(impl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(impl_->display, impl_->context);
}

void HeadlessContext::MakeCurrent() const {
  if (eglGetCurrentContext() == impl_->context) return;
  if (eglMakeCurrent(impl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, impl_->context) != EGL_TRUE) {
    Fail("cannot make the context current");
  }
}

GlDescription HeadlessContext::Describe() const {
  constexpr unsigned kGlRenderer = 0x1f01;
  constexpr unsigned kGlVersion = 0x1f02;
  return {GlString(kGlRenderer), GlString(kGlVersion)};
}

const void* CurrentContext() { return eglGetCurrentContext(); }

}  // namespace pleinair
