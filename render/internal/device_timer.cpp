#include "render/internal/device_timer.h"

namespace pleinair {
namespace {

GLuint64 NanosecondsOf(const GlObject& query) {
  GLuint64 time_ns = 0;
  glGetQueryObjectui64v(query.Name(), GL_QUERY_RESULT, &time_ns);
  return time_ns;
}

}  // namespace

DeviceTimer::DeviceTimer() {
  if (!epoxy_is_desktop_gl()) return;
  start_ = MakeQuery();
  stop_ = MakeQuery();
}

void DeviceTimer::Start() {
  if (start_) glQueryCounter(start_.Name(), GL_TIMESTAMP);
}

void DeviceTimer::Stop() {
  if (stop_) glQueryCounter(stop_.Name(), GL_TIMESTAMP);
}

double DeviceTimer::Ms() const {
  if (!start_) return 0.0;
  return 1e-6 * static_cast<double>(NanosecondsOf(stop_) - NanosecondsOf(start_));
}

}  // namespace pleinair
