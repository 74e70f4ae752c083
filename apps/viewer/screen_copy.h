// Parts of a window's picture on the screen, in place of all of it.
#pragma once

#include <optional>

#include <glm/vec2.hpp>

namespace pleinair {

// Shows a part of the back buffer, which stays as it is: a swap of buffers would leave it
// undefined.
class ScreenCopy {
 public:
  // For the current context's window. None where the driver cannot, and where a graphics card
  // draws: that has drawn all of a window in the time that it takes to find a part.
  static std::optional<ScreenCopy> Make();

  // In pixels, counted from below. Throws nothing.
  void Show(const glm::ivec2& low, const glm::ivec2& size) const;

 private:
  // Functions of GLX, without X's header, whose macros are common words.
  using CurrentDisplay = void* (*)();
  using CurrentDrawable = unsigned long (*)();
  using CopySubBuffer = void (*)(void*, unsigned long, int, int, int, int);

  CurrentDisplay display_ = nullptr;
  CurrentDrawable drawable_ = nullptr;
  CopySubBuffer copy_ = nullptr;
};

}  // namespace pleinair
