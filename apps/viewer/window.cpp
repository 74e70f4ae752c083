#include "apps/viewer/window.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <epoxy/gl.h>
// After epoxy, which declares OpenGL.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

#include "apps/viewer/drawn_part.h"

namespace pleinair {
namespace {

constexpr float kFontSizePx = 15.0f;

std::string& LastGlfwError() {
  static std::string error;
  return error;
}

[[noreturn]] void Fail(const std::string& what) {
  const std::string why = LastGlfwError();
  glfwTerminate();
  throw std::runtime_error("view: " + what + (why.empty() ? std::string() : " (" + why + ")"));
}

void SetUpStyle(float scale) {
  ImFontConfig font;
  font.SizePixels = std::round(kFontSizePx * scale);
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 4.0f;
  style.FrameRounding = 3.0f;
  style.ScaleAllSizes(scale);
}

}  // namespace

ViewWindow::ViewWindow(const std::string& title,
                       const ScreenPlace& place,
                       const std::filesystem::path& layout)
    : layout_(layout.string()) {
  glfwSetErrorCallback([](int, const char* text) { LastGlfwError() = text; });
  if (glfwInit() != GLFW_TRUE) {
    Fail(
        "no display: expected an X11 or Wayland session (`xvfb-run -a pleinair view ...` makes "
        "one without a screen; `pleinair run` needs none)");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_MAXIMIZED, place.is_maximised ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glm::ivec2 origin(0);
  glm::ivec2 screen(place.width, place.height);
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor(); monitor != nullptr) {
    glfwGetMonitorWorkarea(monitor, &origin.x, &origin.y, &screen.x, &screen.y);
    glm::vec2 scale(1.0f);
    glfwGetMonitorContentScale(monitor, &scale.x, &scale.y);
    screen = glm::ivec2(glm::vec2(screen) / scale);
  }
  window_ = glfwCreateWindow(std::min(place.width, screen.x),
                             std::min(place.height, screen.y),
                             title.c_str(),
                             nullptr,
                             nullptr);
  if (window_ == nullptr) Fail("no window: expected OpenGL 3.3 on this display");
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(0);  // A wait for the screen would hold up input.
  screen_copy_ = ScreenCopy::Make();
  float scale_y = 1.0f;
  glfwGetWindowContentScale(window_, &content_scale_, &scale_y);

  glfwSetWindowUserPointer(window_, this);
  // Each with arguments of its own; any of them is input.
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int mods) {
    Self(w).has_input_ = true;
    if (action == GLFW_RELEASE) return;
    Self(w).keys_.push_back({Self(w).edges_.size(),
                             key,
                             (mods & GLFW_MOD_CONTROL) != 0,
                             (mods & GLFW_MOD_ALT) != 0,
                             (mods & GLFW_MOD_SHIFT) != 0,
                             action == GLFW_REPEAT});
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned) { Self(w).has_input_ = true; });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int mods) {
    Self(w).has_input_ = true;
    if (button != GLFW_MOUSE_BUTTON_LEFT) return;
    (action == GLFW_PRESS ? Self(w).pressed_at_ : Self(w).released_at_) = Self(w).pointer_;
    Self(w).edges_.push_back(
        {Self(w).pointer_, action == GLFW_PRESS, (mods & GLFW_MOD_SHIFT) != 0});
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    Self(w).has_input_ = true;
    Self(w).pointer_ = {x, y};
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double) { Self(w).has_input_ = true; });
  glfwSetFramebufferSizeCallback(window_,
                                 [](GLFWwindow* w, int, int) { Self(w).has_input_ = true; });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { Self(w).has_input_ = true; });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    Self(w).has_input_ = true;
    Self(w).drop_.files.assign(paths, paths + count);
    glfwGetCursorPos(w, &Self(w).drop_.at.x, &Self(w).drop_.at.y);
  });

  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = layout_.empty() ? nullptr : layout_.c_str();
  SetUpStyle(content_scale_);
  // It calls the callbacks above, too.
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330");
}

ViewWindow::~ViewWindow() {
  if (backdrop_frame_ != 0) glDeleteFramebuffers(1, &backdrop_frame_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

ViewWindow& ViewWindow::Self(GLFWwindow* window) {
  return *static_cast<ViewWindow*>(glfwGetWindowUserPointer(window));
}

bool ViewWindow::IsToClose() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }
void ViewWindow::Close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
void ViewWindow::StayOpen() { glfwSetWindowShouldClose(window_, GLFW_FALSE); }
bool ViewWindow::IsShown() const {
  return glfwGetWindowAttrib(window_, GLFW_VISIBLE) == GLFW_TRUE &&
         glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_FALSE;
}
void ViewWindow::SetTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }
void ViewWindow::Wait(double seconds) { glfwWaitEventsTimeout(seconds); }
void ViewWindow::Wake() { glfwPostEmptyEvent(); }

void ViewWindow::BeginFrame() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  // Dear ImGui sees which keys are down as a frame begins: one that was pressed and let go since
  // the last one is down for this frame.
  const auto set_tapped = [&](bool is_down) {
    for (const KeyPress& press : keys_) {
      if (press.key < 0 || glfwGetKey(window_, press.key) == GLFW_PRESS) continue;
      ImGui::GetIO().KeysDown[press.key] = is_down;
    }
  };
  set_tapped(true);
  ImGui::NewFrame();
  set_tapped(false);
}

void ViewWindow::EndFrame(bool draws_all) {
  ImGui::Render();
  const glm::ivec2 size = FramebufferSize();
  glViewport(0, 0, size.x, size.y);
  const Part picture = BackdropPart();
  const Part shown{glm::min(picture.low, size), glm::min(picture.high, size)};
  const bool draws_part = !draws_all && copied_size_ == size &&
                          glm::all(glm::lessThan(shown.low, shown.high)) &&
                          !CutsAWindow(*ImGui::GetDrawData(), backdrop_.low, backdrop_.high);
  if (!draws_part) {
    glClearColor(0.09f, 0.09f, 0.1f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
  }
  CopyBackdrop(picture, size.y);
  if (draws_part) {
    DrawWithin(shown);
  } else {
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }
  backdrop_ = {};
  // The back buffer gets the window's size at the first drawing after a swap: a copy of more than
  // it has is an error of the display, which ends the program.
  if (screen_copy_ && swapped_size_ == size && FramebufferSize() == size) {
    const Part part = draws_part ? shown : Part{{0, 0}, size};
    screen_copy_->Show({part.low.x, size.y - part.high.y}, part.high - part.low);
    copied_size_ = size;
  } else {
    glfwSwapBuffers(window_);
    swapped_size_ = size;
    copied_size_.reset();
  }
}

glm::ivec2 ViewWindow::FramebufferSize() const {
  glm::ivec2 size(0);
  glfwGetFramebufferSize(window_, &size.x, &size.y);
  return size;
}

void ViewWindow::ShowBehind(const Texture& picture, const glm::dvec2& low, const glm::dvec2& high) {
  backdrop_ = {picture.Name(), {picture.Width(), picture.Height()}, low, high};
}

ViewWindow::Part ViewWindow::BackdropPart() const {
  const ImVec2 density = ImGui::GetIO().DisplayFramebufferScale;
  return {glm::ivec2(glm::round(backdrop_.low * glm::dvec2(density.x, density.y))),
          glm::ivec2(glm::round(backdrop_.high * glm::dvec2(density.x, density.y)))};
}

void ViewWindow::CopyBackdrop(const Part& part, int framebuffer_height) {
  if (backdrop_.texture == 0) return;
  if (backdrop_frame_ == 0) glGenFramebuffers(1, &backdrop_frame_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, backdrop_frame_);
  glFramebufferTexture2D(
      GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, backdrop_.texture, 0);
  const bool is_reduced = part.high.x - part.low.x < backdrop_.size.x;
  // OpenGL counts rows from below.
  glBlitFramebuffer(0,
                    0,
                    backdrop_.size.x,
                    backdrop_.size.y,
                    part.low.x,
                    framebuffer_height - part.low.y,
                    part.high.x,
                    framebuffer_height - part.high.y,
                    GL_COLOR_BUFFER_BIT,
                    is_reduced ? GL_LINEAR : GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

// What Dear ImGui has made, over the picture.
void ViewWindow::DrawWithin(const Part& part) {
  ImDrawData data = *ImGui::GetDrawData();
  const ImVec2 density = data.FramebufferScale;
  const auto left = static_cast<float>(part.low.x) / density.x;
  const auto top = static_cast<float>(part.low.y) / density.y;
  const auto right = static_cast<float>(part.high.x) / density.x;
  const auto bottom = static_cast<float>(part.high.y) / density.y;
  std::vector<ImDrawList*> lists;
  for (ImDrawList* list : std::span(data.CmdLists, static_cast<std::size_t>(data.CmdListsCount))) {
    bool is_within = false;
    // The commands are made again for the next picture.
    for (ImDrawCmd& command : list->CmdBuffer) {
      ImVec4& clip = command.ClipRect;
      clip = {std::max(clip.x, left),
              std::max(clip.y, top),
              std::min(clip.z, right),
              std::min(clip.w, bottom)};
      is_within |= clip.x < clip.z && clip.y < clip.w;
    }
    if (is_within) lists.push_back(list);
  }
  data.CmdLists = lists.data();
  data.CmdListsCount = static_cast<int>(lists.size());
  ImGui_ImplOpenGL3_RenderDrawData(&data);
}

ScreenPlace ViewWindow::Place() const {
  ScreenPlace place;
  glfwGetWindowSize(window_, &place.width, &place.height);
  glm::ivec2 pixels(0);
  glfwGetFramebufferSize(window_, &pixels.x, &pixels.y);
  // Else the window's units are scaled already.
  if (pixels.x == place.width) {
    place.width = static_cast<int>(std::lround(static_cast<float>(place.width) / content_scale_));
    place.height = static_cast<int>(std::lround(static_cast<float>(place.height) / content_scale_));
  }
  place.is_maximised = glfwGetWindowAttrib(window_, GLFW_MAXIMIZED) == GLFW_TRUE;
  return place;
}

bool ViewWindow::TakeInput() { return std::exchange(has_input_, false); }
std::vector<ViewWindow::PointerEdge> ViewWindow::TakeEdges() { return std::exchange(edges_, {}); }
std::vector<ViewWindow::KeyPress> ViewWindow::TakeKeys() { return std::exchange(keys_, {}); }
ViewWindow::Drop ViewWindow::TakeDrop() { return std::exchange(drop_, {}); }

Texture::~Texture() {
  if (name_ != 0) glDeleteTextures(1, &name_);
}

void Texture::Upload(const Rgb8Image& picture) {
  Upload(picture.width, picture.height, GL_RGB, picture.pixels.data());
}

void Texture::Upload(const Rgba8Image& picture) {
  Upload(picture.width, picture.height, GL_RGBA, picture.pixels.data());
}

void* Texture::Id() const {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): Dear ImGui takes OpenGL's names as pointers.
  return reinterpret_cast<void*>(static_cast<std::uintptr_t>(name_));
}

void Texture::Upload(int width, int height, unsigned format, const void* pixels) {
  if (name_ == 0) {
    glGenTextures(1, &name_);
    glBindTexture(GL_TEXTURE_2D, name_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  glBindTexture(GL_TEXTURE_2D, name_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (width == width_ && height == height_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, format, GL_UNSIGNED_BYTE, pixels);
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, format, GL_UNSIGNED_BYTE, pixels);
    width_ = width;
    height_ = height;
  }
}

}  // namespace pleinair
