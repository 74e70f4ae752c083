#include "render/internal/checked_context.h"

#include <stdexcept>
#include <string>

#include <epoxy/gl.h>

#include "render/internal/current_context.h"
#include "render/software_driver.h"

namespace pleinair {
namespace {

void RequireContext() {
  if (glGetString(GL_VERSION) == nullptr) {
    throw std::runtime_error("compositor: no OpenGL context is current on this thread");
  }
  const int version = epoxy_gl_version();
  const bool is_desktop = epoxy_is_desktop_gl();
  if (version < (is_desktop ? 45 : 31)) {
    throw std::runtime_error(std::string("compositor: this context is ") +
                             (is_desktop ? "OpenGL " : "OpenGL ES ") +
                             std::to_string(version / 10) + "." + std::to_string(version % 10) +
                             ", expected " + (is_desktop ? "4.5" : "3.1") + " or later");
  }
  if (!is_desktop && version < 32 && !epoxy_has_gl_extension("GL_EXT_color_buffer_half_float") &&
      !epoxy_has_gl_extension("GL_EXT_color_buffer_float")) {
    throw std::runtime_error(
        "compositor: this OpenGL ES context draws into no half floats: expected ES 3.2, "
        "GL_EXT_color_buffer_half_float or GL_EXT_color_buffer_float");
  }
}

}  // namespace

CheckedContext::CheckedContext() {
  RequireContext();
  made_in_ = CurrentContext();
  reports_loss_ = epoxy_gl_version() >= (epoxy_is_desktop_gl() ? 45 : 32);
  draws_in_software_ = DrawsOnProcessor(reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
}

void CheckedContext::RequireCurrent() const {
  if (CurrentContext() == made_in_) return;
  throw std::runtime_error(
      "compositor: the OpenGL context that it was made in is not current on this thread");
}

void CheckedContext::RequireNotLost() const {
  if (reports_loss_ && glGetGraphicsResetStatus() != GL_NO_ERROR) {
    throw std::runtime_error(
        "compositor: the OpenGL context has been lost (the device was reset or taken away): "
        "expected a new one in another context");
  }
}

}  // namespace pleinair
