#include "apps/viewer/screen_copy.h"

#include <epoxy/gl.h>
// After epoxy, which declares OpenGL.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "render/software_driver.h"

namespace pleinair {
namespace {

template <typename Function>
Function Find(const char* name) {
  return reinterpret_cast<Function>(glfwGetProcAddress(name));
}

}  // namespace

std::optional<ScreenCopy> ScreenCopy::Make() {
  if (!DrawsOnProcessor(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) ||
      glfwExtensionSupported("GLX_MESA_copy_sub_buffer") != GLFW_TRUE) {
    return std::nullopt;
  }
  ScreenCopy copy;
  copy.display_ = Find<CurrentDisplay>("glXGetCurrentDisplay");
  copy.drawable_ = Find<CurrentDrawable>("glXGetCurrentDrawable");
  copy.copy_ = Find<CopySubBuffer>("glXCopySubBufferMESA");
  if (copy.display_ == nullptr || copy.drawable_ == nullptr || copy.copy_ == nullptr) {
    return std::nullopt;
  }
  return copy;
}

void ScreenCopy::Show(const glm::ivec2& low, const glm::ivec2& size) const {
  copy_(display_(), drawable_(), low.x, low.y, size.x, size.y);
}

}  // namespace pleinair
