// A window with an OpenGL context and Dear ImGui in it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "apps/viewer/overlay.h"
#include "apps/viewer/screen_copy.h"

struct GLFWwindow;

namespace pleinair {

// A picture on the graphics device; of the context that was current when it was made.
class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  void Upload(const Rgb8Image& picture);
  void Upload(const Rgba8Image& picture);
  void* Id() const;
  unsigned Name() const { return name_; }
  int Width() const { return width_; }
  int Height() const { return height_; }

 private:
  void Upload(int width, int height, unsigned format, const void* pixels);
  unsigned name_ = 0;
  int width_ = 0;
  int height_ = 0;
};

// Its size on a screen of content scale 1; others scale it.
struct ScreenPlace {
  int width = 1280;
  int height = 800;
  bool is_maximised = false;
};

class ViewWindow {
 public:
  // `layout`: where Dear ImGui keeps its windows' places; empty: nowhere. Throws
  // std::runtime_error, one line, without a display or OpenGL 3.3.
  ViewWindow(const std::string& title,
             const ScreenPlace& place,
             const std::filesystem::path& layout);
  ~ViewWindow();
  ViewWindow(const ViewWindow&) = delete;
  ViewWindow& operator=(const ViewWindow&) = delete;

  bool IsToClose() const;
  void Close();
  void StayOpen();       // After it was to be closed.
  bool IsShown() const;  // Neither hidden nor an icon.
  void SetTitle(const std::string& title);
  // For input, a Wake, or so long.
  void Wait(double seconds);
  // From any thread: ends a Wait.
  static void Wake();

  void BeginFrame();
  // Behind all else of this frame, between these corners; copied, which is faster than drawing.
  void ShowBehind(const Texture& picture, const glm::dvec2& low, const glm::dvec2& high);
  // On the screen. `draws_all`: else only what is within the corners of ShowBehind is drawn again,
  // where the driver allows that and no window lies over their edge; panels beside it then stay as
  // they were.
  void EndFrame(bool draws_all);

  ScreenPlace Place() const;
  // Scale of the screen: above 1 where it has more than about 96 dots an inch.
  float ContentScale() const { return content_scale_; }
  // Whether there was input since the last call.
  bool TakeInput();
  // Presses and releases of the pointer's left button since the last call, in order: Dear ImGui
  // has one a frame, where the pointer then is.
  struct PointerEdge {
    glm::dvec2 at{0.0};
    bool is_press = false;
    bool shift = false;
  };
  std::vector<PointerEdge> TakeEdges();
  // Keys that were pressed, or repeat, since the last call: also those that were released before
  // anyone looked.
  struct KeyPress {
    std::size_t after_edges = 0;  // How many of the edges from TakeEdges precede it.
    int key = 0;                  // GLFW_KEY_...
    bool ctrl = false;
    bool alt = false;
    bool shift = false;
    bool is_repeat = false;
  };
  std::vector<KeyPress> TakeKeys();
  // Where the pointer's left button was last pressed and released: by the time that anyone looks,
  // the pointer may be elsewhere.
  const glm::dvec2& PressedAt() const { return pressed_at_; }
  const glm::dvec2& ReleasedAt() const { return released_at_; }
  // Files that were dropped on it since the last call, and where.
  struct Drop {
    std::vector<std::filesystem::path> files;
    glm::dvec2 at{0.0};
  };
  Drop TakeDrop();

 private:
  static ViewWindow& Self(GLFWwindow* window);

  glm::ivec2 FramebufferSize() const;
  // A part of the framebuffer, in pixels from above.
  struct Part {
    glm::ivec2 low{0};
    glm::ivec2 high{0};
  };
  Part BackdropPart() const;
  void CopyBackdrop(const Part& part, int framebuffer_height);
  static void DrawWithin(const Part& part);

  GLFWwindow* window_ = nullptr;
  struct Backdrop {
    unsigned texture = 0;  // 0: none.
    glm::ivec2 size{0};
    glm::dvec2 low{0.0};
    glm::dvec2 high{0.0};
  };
  Backdrop backdrop_;
  unsigned backdrop_frame_ = 0;  // That the texture is read through.
  std::optional<ScreenCopy> screen_copy_;
  glm::ivec2 swapped_size_{0};             // Size of the framebuffer at the last swap.
  std::optional<glm::ivec2> copied_size_;  // Size of what the back buffer holds; none: undefined.
  std::string layout_;
  float content_scale_ = 1.0f;
  bool has_input_ = true;
  std::vector<KeyPress> keys_;
  std::vector<PointerEdge> edges_;
  glm::dvec2 pointer_{0.0};
  glm::dvec2 pressed_at_{0.0};
  glm::dvec2 released_at_{0.0};
  Drop drop_;
};

}  // namespace pleinair
