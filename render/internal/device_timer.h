// The time that a device takes to draw, by its own clock.
#pragma once

#include "render/internal/gl_object.h"

namespace pleinair {

// By time stamps (GL_TIMESTAMP), so that an application's own timer may run at the same time.
class DeviceTimer {
 public:
  DeviceTimer();

  void Start();
  void Stop();
  // From the end of what was drawn before Start to the end of what was drawn before Stop, pauses of
  // the device included; waits for it. 0 where a context has no time stamps (as OpenGL ES).
  double Ms() const;

 private:
  GlObject start_;
  GlObject stop_;
  GLuint64 mask_ = ~GLuint64{0};
};

}  // namespace pleinair
